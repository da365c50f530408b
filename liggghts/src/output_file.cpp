#include "output_file.h"

#include <cstring>
#include <unistd.h>

#include <cerrno>

#include "error.h"
#include "stop_with_error.h"

namespace ballast {

OutputFile::OutputFile(LAMMPS_NS::LAMMPS *lmp, const std::string &path)
    : lmp_(lmp), path_(path), partial_(path + ".partial"), stream_(fopen(partial_.c_str(), "w")) {
  if (!stream_) fail();
}

OutputFile::~OutputFile() {
  if (stream_) fclose(stream_);
}

void OutputFile::commit() {
  const bool written = fflush(stream_) == 0 && !ferror(stream_) && fsync(fileno(stream_)) == 0;
  const bool closed = fclose(stream_) == 0;
  stream_ = NULL;
  if (!written || !closed || rename(partial_.c_str(), path_.c_str()) != 0) fail();
}

void OutputFile::fail() const {
  const std::string reason = strerror(errno);
  unlink(partial_.c_str());  // on a full disk, half a file is only in the way
  stop_with_error(lmp_,
                  path_ + ": cannot be written (" + reason + "); free disk space or correct permissions, then resume");
}

}  // namespace ballast
