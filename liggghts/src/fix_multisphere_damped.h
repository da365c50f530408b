#ifndef BALLAST_FIX_MULTISPHERE_DAMPED_H
#define BALLAST_FIX_MULTISPHERE_DAMPED_H

#include <vector>

#include "clump_motion.h"
#include "fix_multisphere.h"

namespace LAMMPS_NS {

/// `fix ID all multisphere/damped`: clumps of two equal spheres. Bodies, communication and restart are those of the stock fix; the motion is
/// that of axisymmetric bodies (clump_motion.h), with Cundall's local damping on demand.
///   fix_modify ID local_damping ALPHA      0 (default) is none
class FixMultisphereDamped : public FixMultisphere {
 public:
  FixMultisphereDamped(class LAMMPS *, int, char **);
  void setup(int) override;
  void setup_pre_neighbor() override;
  void pre_neighbor() override;
  void pre_force(int) override {}  // calc_force sets forces instead of adding to them
  void initial_integrate(int) override;
  void final_integrate() override;
  void calc_force(bool setup) override;
  int modify_param(int, char **) override;

 private:
  struct Bodies;
  void find_spheres();
  void gather_motion(const Bodies &bodies, int first, int count);
  void set_spheres(int first, int count, bool positions);

  double local_damping_;
  bool forces_incomplete_;
  ballast::ClumpBatch batch_;
  std::vector<int> spheres_;      // two local or ghost indices per body of this rank
  std::vector<double> offsets_;   // their places on the axis, m
};

}  // namespace LAMMPS_NS

#endif
