'use strict';
// Draws a FacePose on a canvas with WebGL, from the front: key light from above and the viewer's left, a weak fill from
// the right; creases bend the light. The same light as in the pictures of `risorius rig show`.

const kFaceBeginsZMm = 30;  // behind it there are no creases

const kVertexShader = `
  attribute vec3 position, normal, colour, rest;
  attribute float openness;
  uniform vec3 target;
  uniform vec2 scale;  // of the picture, per mm at the target
  uniform float distance;
  varying vec3 vNormal, vColour, vRest;
  varying float vOpenness;
  void main() {
    vec3 view = position - target;
    float away = distance - view.z;
    float near = distance - 300.0, far = distance + 300.0;
    vNormal = normal;
    vColour = colour;
    vRest = rest;
    vOpenness = openness;
    gl_Position = vec4(view.xy * scale * distance, ((far + near) * away - 2.0 * far * near) / (far - near), away);
  }`;

const kFragmentShader = `
  precision highp float;
  varying vec3 vNormal, vColour, vRest;
  varying float vOpenness;
  uniform sampler2D creases;
  uniform vec4 creaseGrid;  // left and lowest place, width and height, mm
  uniform vec2 creaseCell;  // mm, and mm of height per texture unit
  uniform float isSkin, faceBeginsZ;

  float creaseHeight(vec2 place) {
    return (texture2D(creases, (place - creaseGrid.xy) / creaseGrid.zw).r * 255.0 - 128.0) * creaseCell.y;
  }

  vec3 lit(vec3 colour, vec3 normal, float openness) {
    vec3 key = normalize(vec3(-0.55, 0.62, 0.75)), fill = normalize(vec3(0.8, 0.1, 0.55));
    vec3 halfway = normalize(key + vec3(0.0, 0.0, 1.0));
    // Light creeps around the skin's edges: red more than blue.
    vec3 wrap = vec3(0.32, 0.22, 0.18);
    vec3 diffuse = max(vec3(0.0), (dot(normal, key) + wrap) / (1.0 + wrap));
    float around = 0.30 * max(0.0, dot(normal, fill)) + 0.17 + 0.07 * normal.y;
    float gloss = 0.055 * pow(max(0.0, dot(normal, halfway)), 18.0);
    return openness * (colour * (0.92 * diffuse + around) + gloss);
  }

  void main() {
    vec3 normal = normalize(vNormal);
    float openness = vOpenness;
    if (isSkin > 0.5 && vRest.z >= faceBeginsZ) {
      vec2 step = vec2(creaseCell.x, 0.0);
      float height = creaseHeight(vRest.xy);
      vec3 slope = vec3(creaseHeight(vRest.xy + step.xy) - height, creaseHeight(vRest.xy + step.yx) - height, 0.0)
        / creaseCell.x;
      normal = normalize(normal - (slope - dot(normal, slope) * normal));
      openness *= clamp(1.0 + 0.28 * height, 0.5, 1.08);  // little light reaches the bottom
    }
    gl_FragColor = vec4(pow(clamp(lit(vColour, normal, openness), 0.0, 1.0), vec3(1.0 / 2.2)), 1.0);
  }`;

class FaceView {
  /** Throws an Error where the browser has no WebGL. */
  constructor(canvas, face) {
    this.canvas = canvas;
    this.face = face;
    this.gl = canvas.getContext('webgl', { antialias: true, alpha: true });
    if (!this.gl) throw new Error('This browser cannot draw in 3D (WebGL). Please use another one.');
    canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    canvas.addEventListener('webglcontextrestored', () => this.#prepare());
    this.#prepare();
  }

  #prepare() {
    const { gl, face } = this;
    this.program = this.#program();
    gl.useProgram(this.program);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
    gl.clearColor(0, 0, 0, 0);
    this.buffers = {};
    this.#attribute('position', 3, new Float32Array(3 * face.count));
    this.#attribute('normal', 3, new Float32Array(3 * face.count));
    this.#attribute('openness', 1, new Float32Array(face.count));
    this.#attribute('colour', 3, face.colours);
    this.#attribute('rest', 3, face.rest);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, face.triangles, gl.STATIC_DRAW);
    this.#creaseTexture();
    gl.uniform3fv(this.#place('target'), face.camera.target_mm);
    gl.uniform1f(this.#place('distance'), face.camera.distance_mm);
    gl.uniform1f(this.#place('faceBeginsZ'), kFaceBeginsZMm);
  }

  #place(name) { return this.gl.getUniformLocation(this.program, name); }

  #program() {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, kVertexShader], [gl.FRAGMENT_SHADER, kFragmentShader]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost())
      throw new Error('The face cannot be drawn here: ' + gl.getProgramInfoLog(program));
    return program;
  }

  #attribute(name, size, values) {
    const { gl } = this;
    this.buffers[name] = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[name]);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    const place = gl.getAttribLocation(this.program, name);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
  }

  #creaseTexture() {
    const { gl } = this;
    const grid = this.face.creases;
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    for (const [name, value] of [[gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE],
      [gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR]])
      gl.texParameteri(gl.TEXTURE_2D, name, value);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    // A cell's value stands for its place; textures put it into the middle of the cell.
    gl.uniform4f(this.#place('creaseGrid'), grid.left_mm - grid.step_mm / 2, grid.low_mm - grid.step_mm / 2,
      grid.columns * grid.step_mm, grid.rows * grid.step_mm);
    gl.uniform2f(this.#place('creaseCell'), grid.step_mm, grid.height_step_mm);
  }

  draw(pose) {
    const { gl, canvas, face } = this;
    const dots = window.devicePixelRatio || 1;
    const width = Math.max(1, Math.round(canvas.clientWidth * dots));
    const height = Math.max(1, Math.round(canvas.clientHeight * dots));
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    const perMm = 2 / face.camera.field_mm;  // field: height of the picture at the target
    gl.viewport(0, 0, width, height);
    gl.uniform2f(this.#place('scale'), perMm * height / width, perMm);
    for (const [name, values] of [['position', pose.positions], ['normal', pose.normals],
      ['openness', pose.openness]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[name]);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, values);
    }
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.LUMINANCE, face.creases.columns, face.creases.rows, 0, gl.LUMINANCE,
      gl.UNSIGNED_BYTE, pose.creaseHeights);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const skin = 3 * face.skinTriangles;
    gl.uniform1f(this.#place('isSkin'), 1);
    gl.drawElements(gl.TRIANGLES, skin, gl.UNSIGNED_SHORT, 0);
    gl.uniform1f(this.#place('isSkin'), 0);
    gl.drawElements(gl.TRIANGLES, face.triangles.length - skin, gl.UNSIGNED_SHORT, 2 * skin);
  }
}
