#include "capture/wire/curve_keys.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

#include "capture/errors.h"

namespace risorius {
namespace {

constexpr std::size_t kKeyCharacters = 40;
constexpr std::uintmax_t kLongestFileBytes = 65536;
constexpr const char* kRemedy = "make one with: risorius keys NAME";

using KeyText = std::array<char, kKeyCharacters + 1>;

/// What a certificate file says; keys that it does not have stay empty.
CurveKeyPair read_certificate(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw UserError(path.string(), "is a folder", kRemedy);
  const auto bytes = std::filesystem::file_size(path, error);
  if (error) throw UserError(path.string(), "cannot be read: " + error.message(), kRemedy);
  if (bytes > kLongestFileBytes) throw UserError(path.string(), "is too long for a certificate", kRemedy);
  std::ifstream file(path);
  if (!file) throw UserError(path.string(), "cannot be read", "is it readable for this user?");
  CurveKeyPair keys;
  for (std::string line; std::getline(file, line);) {
    const auto begin = line.find_first_not_of(" \t");
    if (begin == std::string::npos || line[begin] == '#') continue;
    for (const auto& [name, key] : {std::pair{"public-key", &keys.public_key}, {"secret-key", &keys.secret_key}}) {
      if (line.compare(begin, std::string_view(name).size(), name) != 0) continue;
      const auto open = line.find('"'), close = line.rfind('"');
      if (open == std::string::npos || close == open) {
        throw UserError(path.string(), fmt::format("{} has no value in quotation marks", name), kRemedy);
      }
      *key = line.substr(open + 1, close - open - 1);
    }
  }
  return keys;
}

/// Never says the key itself: it may be a secret.
void check_key(const std::string& key, const char* name, const std::filesystem::path& path) {
  std::array<std::uint8_t, 32> decoded{};
  if (key.empty()) throw UserError(path.string(), fmt::format("has no {}", name), kRemedy);
  if (key.size() != kKeyCharacters || zmq_z85_decode(decoded.data(), key.c_str()) == nullptr) {
    throw UserError(path.string(), fmt::format("{} is not 40 characters of Z85", name), kRemedy);
  }
}

void write_new_file(const std::filesystem::path& path, const std::string& text, mode_t mode) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (file < 0) {
    const bool exists = errno == EEXIST;
    throw UserError(path.string(), "cannot be written: " + std::generic_category().message(errno),
                    exists ? "a key that is overwritten is lost: give another name" : "give a folder that exists");
  }
  const auto written = ::write(file, text.data(), text.size());
  const int problem = errno;
  if (::close(file) == 0 && written == static_cast<ssize_t>(text.size())) return;
  ::unlink(path.c_str());
  throw UserError(path.string(), "cannot be written: " + std::generic_category().message(problem), "is the disk full?");
}

}  // namespace

CurveKeyPair make_curve_key_pair() {
  KeyText public_key{}, secret_key{};
  if (zmq_curve_keypair(public_key.data(), secret_key.data()) != 0) {
    throw UserError("CURVE", "this build of ZeroMQ cannot encrypt", "install a libzmq that was built with libsodium");
  }
  return {public_key.data(), secret_key.data()};
}

void write_curve_certificate(const std::filesystem::path& stem, const CurveKeyPair& keys) {
  const std::filesystem::path public_path = stem.string() + ".key", secret_path = stem.string() + ".key_secret";
  std::error_code ignored;
  if (std::filesystem::exists(public_path, ignored)) {
    throw UserError(public_path.string(), "exists", "a key that is overwritten is lost: give another name");
  }
  write_new_file(secret_path,
                 fmt::format("# ZeroMQ CURVE **secret** certificate: never give it to anybody\n"
                             "metadata\ncurve\n    public-key = \"{}\"\n    secret-key = \"{}\"\n",
                             keys.public_key, keys.secret_key),
                 S_IRUSR | S_IWUSR);
  try {
    write_new_file(public_path,
                   fmt::format("# ZeroMQ CURVE public certificate: give it to those who connect\n"
                               "metadata\ncurve\n    public-key = \"{}\"\n",
                               keys.public_key),
                   S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH);
  } catch (const UserError&) {
    std::filesystem::remove(secret_path, ignored);
    throw;
  }
}

CurveKeyPair load_curve_secret(const std::filesystem::path& path) {
  CurveKeyPair keys = read_certificate(path);
  if (keys.secret_key.empty() && !keys.public_key.empty()) {
    throw UserError(path.string(), "holds a public key only", "give the .key_secret file");
  }
  check_key(keys.secret_key, "secret-key", path);
  KeyText derived{};
  if (zmq_curve_public(derived.data(), keys.secret_key.c_str()) != 0) {
    throw UserError("CURVE", "this build of ZeroMQ cannot encrypt", "install a libzmq that was built with libsodium");
  }
  if (!keys.public_key.empty() && keys.public_key != derived.data()) {
    throw UserError(path.string(), "public-key does not belong to secret-key", kRemedy);
  }
  keys.public_key = derived.data();
  return keys;
}

std::string load_curve_public(const std::filesystem::path& path) {
  const CurveKeyPair keys = read_certificate(path);
  check_key(keys.public_key, "public-key", path);
  return keys.public_key;
}

std::vector<std::string> load_curve_clients(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) return {load_curve_public(path)};
  std::vector<std::string> keys;
  for (const auto& entry : std::filesystem::directory_iterator(path, error)) {
    if (entry.path().extension() == ".key") keys.push_back(load_curve_public(entry.path()));
  }
  if (error) throw UserError(path.string(), "cannot be read: " + error.message(), "is it readable for this user?");
  if (keys.empty()) {
    throw UserError(path.string(), "holds no .key file, so nobody could connect",
                    "put the public certificates of those in who may");
  }
  std::sort(keys.begin(), keys.end());
  return keys;
}

CurveServer load_curve_server(const std::string& secret_file, const std::string& clients, const std::string& place) {
  if (secret_file.empty()) {
    if (!clients.empty()) {
      throw UserError(place + " curve_clients", "without curve_key nobody can be told apart",
                      "give curve_key, a .key_secret file");
    }
    return {};
  }
  CurveServer server{.keys = load_curve_secret(secret_file), .clients = {}};
  if (!clients.empty()) server.clients = load_curve_clients(clients);
  return server;
}

void use_curve(zmq::socket_t& socket, const CurveClient& client) {
  socket.set(zmq::sockopt::curve_serverkey, client.server_public_key);
  socket.set(zmq::sockopt::curve_publickey, client.keys.public_key);
  socket.set(zmq::sockopt::curve_secretkey, client.keys.secret_key);
}

}  // namespace risorius
