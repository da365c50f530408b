#ifndef BALLAST_FIX_MULTISPHERE_DAMPED_H
#define BALLAST_FIX_MULTISPHERE_DAMPED_H

#include <vector>

#include "clump_motion.h"
#include "fix_multisphere.h"

namespace LAMMPS_NS {

/// `fix ID all multisphere/damped`: clumps of two equal spheres. Bodies, communication and restart are those of the
/// stock fix; the motion is that of axisymmetric bodies (clump_motion.h), with Cundall's local damping on demand.
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
  void post_run() override { update_spheres(); }
  /// Velocities and spins of the spheres at the end of the step. Collective; called at the end of a run, and by what
  /// writes them before.
  void update_spheres();
  int modify_param(int, char **) override;

 private:
  void find_spheres();
  ballast::Clumps clumps();
  void set_spheres(bool positions);

  double local_damping_;
  bool forces_incomplete_;
  bool spheres_behind_;           // by half a step: their velocities, behind those of their clumps
  double mass_, inertia_transverse_, inertia_axial_;  // of every clump
  std::vector<int> spheres_;      // two local or ghost indices per body of this rank
  std::vector<double> offsets_;   // their places on the axis, m
};

}  // namespace LAMMPS_NS

#endif
