#include "fix_multisphere_damped.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "fix_gravity.h"
#include "force.h"
#include "stop_with_error.h"
#include "update.h"

using namespace LAMMPS_NS;

FixMultisphereDamped::FixMultisphereDamped(LAMMPS *lmp, int narg, char **arg)
    : FixMultisphere(lmp, narg, arg),
      local_damping_(0.0),
      forces_incomplete_(false),
      spheres_behind_(false),
      mass_(0.0),
      inertia_transverse_(0.0),
      inertia_axial_(0.0) {}

void FixMultisphereDamped::setup_pre_neighbor() {
  FixMultisphere::setup_pre_neighbor();
  find_spheres();
  // the stock fix sets them when it reads a restart file, rounded otherwise: a resumed run must begin with the same
  // digits
  spheres_behind_ = true;
  update_spheres();
}

void FixMultisphereDamped::pre_neighbor() {
  FixMultisphere::pre_neighbor();
  find_spheres();
}

void FixMultisphereDamped::find_spheres() {
  const int bodies = n_body();
  spheres_.assign(2 * bodies, -1);
  offsets_.assign(2 * bodies, 0.0);
  for (int i = 0; i < atom->nlocal + atom->nghost; i++) {
    const int body = belongs_to(i) < 0 ? -1 : map(belongs_to(i));
    if (body < 0 || !domain->is_owned_or_first_ghost(i)) continue;
    const int sphere = 2 * body + (displace_[i][2] > 0.0);
    spheres_[sphere] = i;
    offsets_[sphere] = displace_[i][2];
  }
  if (bodies == 0) return;
  const double *const *const inertia = data().extract_double_vector("inertia");
  const double *const mass = data().extract_double_scalar("masstotal");
  mass_ = mass[0];
  inertia_transverse_ = inertia[0][0];
  inertia_axial_ = inertia[0][2];
  for (int body = 0; body < bodies; body++)
    if (spheres_[2 * body] < 0 || spheres_[2 * body + 1] < 0 || mass[body] != mass_ ||
        inertia[body][0] != inertia_transverse_ || inertia[body][1] != inertia_transverse_ ||
        inertia[body][2] != inertia_axial_)
      error->one(
          FLERR,
          "fix multisphere/damped: its bodies must be equal clumps of two spheres; place them with the command place");
}

/// The stock fix's tables of bodies.
ballast::Clumps FixMultisphereDamped::clumps() {
  auto table = [this](const char *name) { return n_body() ? data().extract_double_vector(name)[0] : NULL; };
  double *const quaternion =
      n_body() ? data().prop().getElementProperty<VectorContainer<double, 4>>("quat")->begin()[0] : NULL;
  return {n_body(),        mass_,          inertia_transverse_, inertia_axial_,    table("xcm"),
          table("vcm"),    quaternion,     table("ex_space"),   table("ey_space"), table("ez_space"),
          table("angmom"), table("omega"), table("fcm"),        table("torque")};
}

void FixMultisphereDamped::setup(int vflag) {
  FixMultisphere::setup(vflag);
  // walls defined after this fix add their contact forces only after this point
  forces_incomplete_ = true;
}

void FixMultisphereDamped::set_spheres(bool positions) {
  const ballast::Clumps c = clumps();
  double *const *const x = atom->x, *const *const v = atom->v, *const *const omega = atom->omega;
  for (int body = 0; body < c.number; body++) {
    const double *const centre = c.centre + 3 * body, *const velocity = c.velocity + 3 * body;
    const double *const n = c.axis + 3 * body, *const w = c.spin + 3 * body;
    const double turning[3] = {w[1] * n[2] - w[2] * n[1], w[2] * n[0] - w[0] * n[2], w[0] * n[1] - w[1] * n[0]};
    for (int s = 2 * body; s < 2 * body + 2; s++) {
      const int i = spheres_[s];
      const double offset = offsets_[s];
      for (int d = 0; d < 3; d++) {
        if (positions) x[i][d] = centre[d] + offset * n[d];
        v[i][d] = velocity[d] + offset * turning[d];
        omega[i][d] = w[d];
      }
    }
  }
}

void FixMultisphereDamped::update_spheres() {
  if (!spheres_behind_) return;
  set_spheres(false);
  rev_comm_flag_ = MS_COMM_REV_V_OMEGA;
  reverse_comm();
  fw_comm_flag_ = MS_COMM_FW_V_OMEGA;
  forward_comm();
  spheres_behind_ = false;
}

void FixMultisphereDamped::initial_integrate(int) {
  if (forces_incomplete_) {
    comm_correct_force(true);
    calc_force(true);
    forces_incomplete_ = false;
  }
  evflag = 0;
  ballast::kick_and_drift(clumps(), update->dt);
  set_spheres(true);
  rev_comm_flag_ = MS_COMM_REV_X_V_OMEGA;
  reverse_comm();
}

void FixMultisphereDamped::calc_force(bool setup) {
  const ballast::Clumps c = clumps();
  const double *const *const f = atom->f, *const *const torque = atom->torque;
  double gravity[3] = {0.0, 0.0, 0.0};
  if (fix_gravity_) fix_gravity_->get_gravity(gravity);
  for (int body = 0; body < c.number; body++) {
    const double *const fa = f[spheres_[2 * body]], *const fb = f[spheres_[2 * body + 1]];
    const double *const ta = torque[spheres_[2 * body]], *const tb = torque[spheres_[2 * body + 1]];
    const double at_a = offsets_[2 * body], at_b = offsets_[2 * body + 1];
    const double *const n = c.axis + 3 * body;
    double *const net_force = c.force + 3 * body, *const net_torque = c.torque + 3 * body;
    const double lever[3] = {at_a * fa[0] + at_b * fb[0], at_a * fa[1] + at_b * fb[1], at_a * fa[2] + at_b * fb[2]};
    for (int d = 0; d < 3; d++) net_force[d] = fa[d] + fb[d] + c.mass * gravity[d];
    net_torque[0] = ta[0] + tb[0] + (n[1] * lever[2] - n[2] * lever[1]);
    net_torque[1] = ta[1] + tb[1] + (n[2] * lever[0] - n[0] * lever[2]);
    net_torque[2] = ta[2] + tb[2] + (n[0] * lever[1] - n[1] * lever[0]);
  }
  // during a step velocities are half a step behind the forces, at setup they are level with them
  if (local_damping_ != 0.0) ballast::damp(c, local_damping_, setup ? 0.0 : 0.5 * update->dt);
}

void FixMultisphereDamped::final_integrate() {
  calc_force(false);
  ballast::kick(clumps(), update->dt);
  spheres_behind_ = true;
}

int FixMultisphereDamped::modify_param(int narg, char **arg) {
  if (strcmp(arg[0], "local_damping") != 0) return 0;
  if (narg < 2) ballast::stop_with_error(lmp, "fix_modify local_damping: value missing; give a number from 0 to 1");
  local_damping_ = force->numeric(FLERR, arg[1]);
  if (local_damping_ < 0.0 || local_damping_ >= 1.0)
    ballast::stop_with_error(lmp, "fix_modify local_damping: out of range; give a number from 0 to below 1");
  return 2;
}
