// The study as one HTML file that needs nothing but a browser: the face, the clips, the page's own scripts.
#pragma once

#include <string>

#include "replay/study/study.h"

namespace risorius {

/// `consent` is the line that participants agree to, plain text. The same study gives the same bytes.
std::string study_page(const Study& study, const FaceModel& face, const std::string& consent = {});

}  // namespace risorius
