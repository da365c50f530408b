#ifndef BALLAST_FIX_PROBE_H
#define BALLAST_FIX_PROBE_H

#include <cstdio>
#include <string>
#include <vector>

#include "fix.h"

namespace LAMMPS_NS {

/// `fix ID all ballast/probe EVERY FILE`: all spheres of a small verification case, every EVERY steps, beginning at
/// once. To be defined after clumps and walls, so that the first row has their forces. One rank only. A row is binary
/// doubles: contacts, dashpots at their limit, bonds that hold, and for each sphere in the order of ids centre,
/// velocity, spin, force and torque (three each, SI units).
///   fix_modify ID motion CLUMP VX VY VZ WX WY WZ     velocity (m/s) and spin (rad/s) of a clump, before the first run
class FixProbe : public Fix {
 public:
  FixProbe(class LAMMPS *, int, char **);
  ~FixProbe() override;
  int setmask() override;
  void setup(int) override;
  void end_of_step() override;
  void post_run() override;
  int modify_param(int, char **) override;

 private:
  void write_row();
  void fail();

  std::string path_;
  FILE *file_;
  bigint last_row_;  // step, -1 = none
};

}  // namespace LAMMPS_NS

#endif
