// Files that appear complete or not at all: written aside, then renamed.
#ifndef BALLAST_OUTPUT_FILE_H
#define BALLAST_OUTPUT_FILE_H

#include <cstdio>
#include <string>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace ballast {

class OutputFile {
 public:
  OutputFile(LAMMPS_NS::LAMMPS *lmp, const std::string &path);
  ~OutputFile();
  FILE *stream() const { return stream_; }
  /// Close and give the file its name. Ends the run with one line if the disk is full.
  void commit();

 private:
  void fail() const;

  LAMMPS_NS::LAMMPS *lmp_;
  std::string path_, partial_;
  FILE *stream_;
};

}  // namespace ballast

#endif
