#include "fix_multisphere_damped.h"

#include <cstring>

#include "error.h"
#include "stop_with_error.h"
#include "force.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace {

double sign(double value) { return (value > 0.0) - (value < 0.0); }

}  // namespace

FixMultisphereDamped::FixMultisphereDamped(LAMMPS *lmp, int narg, char **arg)
    : FixMultisphere(lmp, narg, arg), local_damping_(0.0), forces_incomplete_(false) {}

void FixMultisphereDamped::setup(int vflag) {
  FixMultisphere::setup(vflag);
  // walls defined after this fix add their contact forces only after this point
  forces_incomplete_ = true;
}

void FixMultisphereDamped::initial_integrate(int vflag) {
  if (forces_incomplete_) {
    data().reset_forces(false);
    comm_correct_force(true);
    calc_force(true);
    forces_incomplete_ = false;
  }
  FixMultisphere::initial_integrate(vflag);
}

void FixMultisphereDamped::calc_force(bool setup) {
  FixMultisphere::calc_force(setup);
  if (local_damping_ == 0.0) return;
  double **force_on = data().extract_double_vector("fcm");
  double **torque_on = data().extract_double_vector("torque");
  double velocity[3], spin[3];
  // during a step velocities are half a step behind the forces, at setup they are level with them
  const double ahead = setup ? 0.0 : 0.5 * update->dt;
  for (int body = 0; body < n_body(); body++) {
    data().vcm(velocity, body);
    data().omega(spin, body);
    const double per_mass = ahead / data().mass(body);
    for (int d = 0; d < 3; d++) {
      double &net_force = force_on[body][d], &net_torque = torque_on[body][d];
      net_force *= 1.0 - local_damping_ * sign(net_force * (velocity[d] + per_mass * net_force));
      net_torque *= 1.0 - local_damping_ * sign(net_torque * spin[d]);
    }
  }
}

int FixMultisphereDamped::modify_param(int narg, char **arg) {
  if (strcmp(arg[0], "local_damping") != 0) return FixMultisphere::modify_param(narg, arg);
  if (narg < 2) ballast::stop_with_error(lmp, "fix_modify local_damping: value missing; give a number from 0 to 1");
  local_damping_ = force->numeric(FLERR, arg[1]);
  if (local_damping_ < 0.0 || local_damping_ >= 1.0)
    ballast::stop_with_error(lmp, "fix_modify local_damping: out of range; give a number from 0 to below 1");
  return 2;
}
