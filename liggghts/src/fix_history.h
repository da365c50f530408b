#ifndef BALLAST_FIX_HISTORY_H
#define BALLAST_FIX_HISTORY_H

#include <string>
#include <vector>

#include "fix.h"

namespace LAMMPS_NS {

/// `fix ID all ballast/history EVERY FILE new|append SLEEPER_LOAD PLATE_LOAD_1 ...`: one row of loads and displacements
/// every EVERY steps of the stage, and one at its step 0. `append` goes on with FILE where it exists. Displacements:
/// sleeper positive along its load (down), plates positive against theirs (outward).
class FixHistory : public Fix {
 public:
  FixHistory(class LAMMPS *, int, char **);
  ~FixHistory() override;
  int setmask() override;
  void init() override;
  void setup(int) override;
  void end_of_step() override;

 private:
  void write_header();
  void flush();
  void write_row();
  class FixLoadControl *find_load(const char *id) const;

  int row_interval_;  // steps
  std::string path_;
  FILE *file_;  // rank 0 only
  class FixStage *stage_;
  class FixLoadControl *sleeper_;
  std::vector<class FixLoadControl *> plates_;
};

}  // namespace LAMMPS_NS

#endif
