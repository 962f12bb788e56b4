#include "replay/study/study_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <openssl/evp.h>
#include <span>
#include <string_view>
#include <vector>

#include "capture/check.h"
#include "replay/study/face_data.h"
#include "replay/study/shipped_page.h"

namespace risorius {
namespace {

constexpr double kFullScale = 1.2;  // intensity of the largest number
constexpr std::string_view kConsent =
    "I take part voluntarily and may stop at any time. My answers, with how long each took me, are kept under the code "
    "above, without my name.";

std::string escaped(std::string_view text) {
  std::string html;
  for (const char c : text) {
    switch (c) {
      case '&':
        html += "&amp;";
        break;
      case '<':
        html += "&lt;";
        break;
      case '>':
        html += "&gt;";
        break;
      default:
        html += c;
    }
  }
  return html;
}

std::string base64_of_text(const std::string& text) { return base64_of(std::as_bytes(std::span(text))); }

std::string clip_values(const AuMatrix& clip) {
  std::vector<std::uint16_t> values;
  for (Eigen::Index i = 0; i < clip.size(); ++i) {
    const double share = std::clamp(static_cast<double>(clip.data()[i]) / kFullScale, 0.0, 1.0);
    values.push_back(static_cast<std::uint16_t>(std::lround(65535 * share)));
  }
  return base64_of(std::as_bytes(std::span(values)));
}

/// First digits of the SHA-256: they tell one page from another.
std::string short_hash(const std::string& text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned count = 0;
  RISORIUS_CHECK(EVP_Digest(text.data(), text.size(), digest.data(), &count, EVP_sha256(), nullptr) == 1);
  std::string digits;
  for (std::size_t k = 0; k < 5; ++k) digits += fmt::format("{:02x}", digest[k]);
  return digits;
}

/// What must not be read while answering goes into one encoded text.
nlohmann::json study_data(const Study& study, const std::string& face) {
  nlohmann::json clips = nlohmann::json::array(), trials = nlohmann::json::array();
  for (const AuMatrix& clip : study.clips) clips.push_back({{"frames", clip.rows()}, {"values", clip_values(clip)}});
  for (const StudyTrial& t : study.trials) {
    trials.push_back({{"transition", study.transitions[t.transition]},
                      {"left", study.kinds[t.left_kind]},
                      {"right", study.kinds[t.right_kind]},
                      {"left_clip", t.left_clip},
                      {"right_clip", t.right_clip}});
  }
  // As text: numbers of the page are exact to 2^53 only.
  nlohmann::json key{{"seed", std::to_string(study.seed)}, {"trials", trials}};
  const auto text_of = [](const nlohmann::json& json) {  // names of files need not be UTF-8
    return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  };
  const std::string id = short_hash(face + clips.dump() + text_of(key));
  key["page"] = id;
  return {{"page", id},
          {"rate_hz", study.rate_hz},
          {"full_scale", kFullScale},
          {"key", base64_of_text(text_of(key))},
          {"clips", clips}};
}

void fill_in(std::string& page, std::string_view place, std::string_view text) {
  const std::size_t at = page.find(place);
  RISORIUS_CHECK(at != std::string::npos);
  page.replace(at, place.size(), text);
}

}  // namespace

std::string study_page(const Study& study, const FaceModel& face, const std::string& consent) {
  const std::string face_json = face_data(face, study.aus).dump();
  std::string page(shipped_page_file("study.html"));
  fill_in(page, "{{style}}", shipped_page_file("study.css"));
  fill_in(page, "{{face}}", face_json);
  fill_in(page, "{{study}}", study_data(study, face_json).dump());
  for (const char* script : {"study_face.js", "study_view.js", "study_answers.js", "study.js"})
    fill_in(page, fmt::format("{{{{{}}}}}", script), shipped_page_file(script));
  // Last: whatever stands in it stays as it is.
  fill_in(page, "{{consent}}", escaped(consent.empty() ? kConsent : std::string_view(consent)));
  return page;
}

}  // namespace risorius
