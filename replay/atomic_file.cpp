#include "replay/atomic_file.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>
#include <utility>

#include "capture/check.h"
#include "capture/errors.h"

namespace risorius {
namespace {

constexpr std::size_t kBufferBytes = 64 * 1024;

/// Makes the rename itself durable. A file system that cannot sync a folder is not the user's mistake.
void sync_folder(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace

AtomicFile::AtomicFile(std::filesystem::path path)
    : path_(std::move(path)), partial_path_(path_.string() + ".partial"), unfinished_(partial_path_) {
  descriptor_ = ::open(partial_path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail("cannot be created");
  buffer_.reserve(kBufferBytes);
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!is_committed_) ::unlink(partial_path_.c_str());
}

void AtomicFile::write(std::string_view bytes) {
  RISORIUS_CHECK(descriptor_ >= 0);
  if (buffer_.size() + bytes.size() > kBufferBytes) flush();
  if (bytes.size() >= kBufferBytes) {
    write_at(flushed_bytes_, bytes);
    flushed_bytes_ += bytes.size();
  } else {
    buffer_.append(bytes);
  }
}

void AtomicFile::overwrite(std::uint64_t offset, std::string_view bytes) {
  RISORIUS_CHECK(descriptor_ >= 0);
  flush();
  RISORIUS_CHECK(offset + bytes.size() <= flushed_bytes_);
  write_at(offset, bytes);
}

void AtomicFile::cut_to(std::uint64_t bytes) {
  RISORIUS_CHECK(descriptor_ >= 0 && bytes <= flushed_bytes_);
  buffer_.clear();
  flushed_bytes_ = bytes;
  if (::ftruncate(descriptor_, static_cast<off_t>(bytes)) != 0) fail("cannot be cut");
}

void AtomicFile::commit() {
  RISORIUS_CHECK(descriptor_ >= 0);
  flush();
  if (::fsync(descriptor_) != 0) fail("cannot be made durable");
  if (::close(std::exchange(descriptor_, -1)) != 0) fail("cannot be closed");
  if (::rename(partial_path_.c_str(), path_.c_str()) != 0) fail("cannot be renamed from its .partial name");
  is_committed_ = true;
  sync_folder(path_.parent_path());
}

void AtomicFile::flush() {
  write_at(flushed_bytes_, buffer_);
  flushed_bytes_ += buffer_.size();
  buffer_.clear();
}

void AtomicFile::write_at(std::uint64_t offset, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail("cannot be written");
    offset += static_cast<std::uint64_t>(written);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void AtomicFile::fail(const char* what) const {
  throw UserError(path_.string(), std::string(what) + ": " + std::strerror(errno),
                  "check the folder, its permissions and the space left on the disk");
}

}  // namespace risorius
