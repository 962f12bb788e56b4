#include "replay/dataset/disk_reserve.h"

#include <fcntl.h>
#include <unistd.h>
#include <utility>

namespace risorius {

DiskReserve::DiskReserve(std::filesystem::path path, std::size_t bytes) : path_(std::move(path)), unfinished_(path_) {
  const int descriptor = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) return;
  held_ = ::posix_fallocate(descriptor, 0, static_cast<off_t>(bytes)) == 0;
  ::close(descriptor);
  if (!held_) ::unlink(path_.c_str());
}

DiskReserve::~DiskReserve() { release(); }

void DiskReserve::release() noexcept {
  if (std::exchange(held_, false)) ::unlink(path_.c_str());
}

}  // namespace risorius
