#include "replay/dataset/manifest.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <openssl/evp.h>
#include <vector>

#include "capture/check.h"
#include "capture/errors.h"
#include "replay/atomic_file.h"

namespace risorius {
namespace {

std::string hexadecimal(const unsigned char* bytes, std::size_t count) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    text += kDigits[bytes[i] >> 4];
    text += kDigits[bytes[i] & 15];
  }
  return text;
}

std::vector<std::string> relative_files(const std::filesystem::path& folder) {
  std::vector<std::string> files;
  std::error_code error;
  std::filesystem::recursive_directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::recursive_directory_iterator(); entry.increment(error)) {
    // What a take left unfinished is not part of the dataset.
    if (entry->is_directory(error) && entry->path().extension() == ".partial") entry.disable_recursion_pending();
    const std::string name = entry->path().lexically_relative(folder).generic_string();
    if (entry->is_regular_file(error) && name != kManifestName) files.push_back(name);
    if (error) break;
  }
  if (error) throw UserError(folder.string(), "cannot be listed: " + error.message(), "give a folder that can be read");
  std::sort(files.begin(), files.end());
  return files;
}

/// A line as sha256sum writes it: names with a backslash or a line end are escaped and the line says so by a backslash.
std::string manifest_line(const std::string& digest, const std::string& name) {
  std::string escaped;
  for (const char c : name) {
    if (c == '\\')
      escaped += "\\\\";
    else if (c == '\n')
      escaped += "\\n";
    else if (c == '\r')
      escaped += "\\r";
    else
      escaped += c;
  }
  return (escaped == name ? "" : "\\") + digest + "  " + escaped + "\n";
}

}  // namespace

std::string sha256_of_file(const std::filesystem::path& path) {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> digest(EVP_MD_CTX_new(), &EVP_MD_CTX_free);
  RISORIUS_CHECK(digest != nullptr && EVP_DigestInit_ex(digest.get(), EVP_sha256(), nullptr) == 1);
  std::ifstream file(path, std::ios::binary);
  std::vector<char> buffer(64 * 1024);
  while (file) {
    file.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    RISORIUS_CHECK(EVP_DigestUpdate(digest.get(), buffer.data(), static_cast<std::size_t>(file.gcount())) == 1);
  }
  if (!file.eof() || file.bad()) throw UserError(path.string(), "cannot be read", "check the path and its permissions");
  std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
  unsigned int count = 0;
  RISORIUS_CHECK(EVP_DigestFinal_ex(digest.get(), bytes.data(), &count) == 1);
  return hexadecimal(bytes.data(), count);
}

void write_manifest(const std::filesystem::path& folder) {
  const std::vector<std::string> names = relative_files(folder);
  AtomicFile file(folder / kManifestName);
  for (const std::string& name : names) file.write(manifest_line(sha256_of_file(folder / name), name));
  file.commit();
}

}  // namespace risorius
