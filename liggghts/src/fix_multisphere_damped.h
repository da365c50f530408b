#ifndef BALLAST_FIX_MULTISPHERE_DAMPED_H
#define BALLAST_FIX_MULTISPHERE_DAMPED_H

#include "fix_multisphere.h"

namespace LAMMPS_NS {

/// `fix ID all multisphere/damped`: the stock clumps, with Cundall's local damping on demand.
///   fix_modify ID local_damping ALPHA      0 (default) is none
/// The net force F (gravity included) and torque of every clump are multiplied by 1 - ALPHA sign(F v), component by component, as
/// YADE's NewtonIntegrator does: force with the velocity at the end of the step, torque with the angular velocity at half step.
class FixMultisphereDamped : public FixMultisphere {
 public:
  FixMultisphereDamped(class LAMMPS *, int, char **);
  void setup(int) override;
  void initial_integrate(int) override;
  void calc_force(bool setup) override;
  int modify_param(int, char **) override;

 private:
  double local_damping_;
  bool forces_incomplete_;
};

}  // namespace LAMMPS_NS

#endif
