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
using ballast::ClumpBatch;

/// The stock fix's tables of bodies, in which this fix reads and writes.
struct FixMultisphereDamped::Bodies {
  double **centre, **velocity, **force, **torque, **momentum, **spin, **quaternion, **axis_x, **axis_y, **axis, **inertia, *mass;

  explicit Bodies(Multisphere &data)
      : centre(data.extract_double_vector("xcm")), velocity(data.extract_double_vector("vcm")), force(data.extract_double_vector("fcm")),
        torque(data.extract_double_vector("torque")), momentum(data.extract_double_vector("angmom")),
        spin(data.extract_double_vector("omega")), axis_x(data.extract_double_vector("ex_space")),
        axis_y(data.extract_double_vector("ey_space")), axis(data.extract_double_vector("ez_space")),
        inertia(data.extract_double_vector("inertia")), mass(data.extract_double_scalar("masstotal")) {
    quaternion = data.prop().getElementProperty<VectorContainer<double, 4> >("quat")->begin();
  }
};

FixMultisphereDamped::FixMultisphereDamped(LAMMPS *lmp, int narg, char **arg)
    : FixMultisphere(lmp, narg, arg), local_damping_(0.0), forces_incomplete_(false) {}

void FixMultisphereDamped::setup_pre_neighbor() {
  FixMultisphere::setup_pre_neighbor();
  find_spheres();
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
  const Bodies table(data());
  for (int body = 0; body < bodies; body++) {
    const double *inertia = table.inertia[body];
    if (spheres_[2 * body] < 0 || spheres_[2 * body + 1] < 0 || std::fabs(inertia[0] - inertia[1]) > 1e-9 * inertia[0])
      error->one(FLERR, "fix multisphere/damped: a body is no clump of two equal spheres; place clumps with place_clumps");
  }
}

void FixMultisphereDamped::setup(int vflag) {
  FixMultisphere::setup(vflag);
  // walls defined after this fix add their contact forces only after this point
  forces_incomplete_ = true;
}

void FixMultisphereDamped::gather_motion(const Bodies &bodies, int first, int count) {
  ClumpBatch &c = batch_;
  for (int k = 0; k < count; k++) {
    const int body = first + k;
    c.mass[k] = bodies.mass[body];
    c.inertia_transverse[k] = bodies.inertia[body][0];
    c.inertia_axial[k] = bodies.inertia[body][2];
    for (int d = 0; d < 3; d++) {
      c.velocity[d][k] = bodies.velocity[body][d];
      c.momentum[d][k] = bodies.momentum[body][d];
      c.axis[d][k] = bodies.axis[body][d];
      c.force[d][k] = bodies.force[body][d];
      c.torque[d][k] = bodies.torque[body][d];
    }
  }
}

/// Velocities, spins and, on demand, positions of the spheres of a batch.
void FixMultisphereDamped::set_spheres(int first, int count, bool positions) {
  const ClumpBatch &c = batch_;
  double *const *const x = atom->x, *const *const v = atom->v, *const *const omega = atom->omega;
  for (int k = 0; k < count; k++) {
    const double nx = c.axis[0][k], ny = c.axis[1][k], nz = c.axis[2][k];
    const double wx = c.spin[0][k], wy = c.spin[1][k], wz = c.spin[2][k];
    const double rx = wy * nz - wz * ny, ry = wz * nx - wx * nz, rz = wx * ny - wy * nx;
    for (int s = 2 * (first + k); s < 2 * (first + k) + 2; s++) {
      const int i = spheres_[s];
      const double offset = offsets_[s];
      if (positions) {
        x[i][0] = c.centre[0][k] + offset * nx;
        x[i][1] = c.centre[1][k] + offset * ny;
        x[i][2] = c.centre[2][k] + offset * nz;
      }
      v[i][0] = c.velocity[0][k] + offset * rx;
      v[i][1] = c.velocity[1][k] + offset * ry;
      v[i][2] = c.velocity[2][k] + offset * rz;
      omega[i][0] = wx;
      omega[i][1] = wy;
      omega[i][2] = wz;
    }
  }
}

void FixMultisphereDamped::initial_integrate(int) {
  if (forces_incomplete_) {
    comm_correct_force(true);
    calc_force(true);
    forces_incomplete_ = false;
  }
  evflag = 0;
  const Bodies bodies(data());
  ClumpBatch &c = batch_;
  for (int first = 0; first < n_body(); first += ClumpBatch::SIZE) {
    const int count = std::min(ClumpBatch::SIZE + 0, n_body() - first);
    gather_motion(bodies, first, count);
    for (int k = 0; k < count; k++) {
      for (int d = 0; d < 3; d++) c.centre[d][k] = bodies.centre[first + k][d];
      for (int d = 0; d < 4; d++) c.quaternion[d][k] = bodies.quaternion[first + k][d];
    }
    ballast::kick_and_drift(c, update->dt);
    for (int k = 0; k < count; k++) {
      const int body = first + k;
      for (int d = 0; d < 3; d++) {
        bodies.centre[body][d] = c.centre[d][k];
        bodies.velocity[body][d] = c.velocity[d][k];
        bodies.momentum[body][d] = c.momentum[d][k];
        bodies.spin[body][d] = c.spin[d][k];
        bodies.axis_x[body][d] = c.axis_x[d][k];
        bodies.axis_y[body][d] = c.axis_y[d][k];
        bodies.axis[body][d] = c.axis[d][k];
      }
      for (int d = 0; d < 4; d++) bodies.quaternion[body][d] = c.quaternion[d][k];
    }
    set_spheres(first, count, true);
  }
  rev_comm_flag_ = MS_COMM_REV_X_V_OMEGA;
  reverse_comm();
}

void FixMultisphereDamped::calc_force(bool setup) {
  const Bodies bodies(data());
  const double *const *const f = atom->f, *const *const torque = atom->torque;
  double gravity[3] = {0.0, 0.0, 0.0};
  if (fix_gravity_) fix_gravity_->get_gravity(gravity);
  // during a step velocities are half a step behind the forces, at setup they are level with them
  const double ahead = setup ? 0.0 : 0.5 * update->dt;
  for (int body = 0; body < n_body(); body++) {
    const int a = spheres_[2 * body], b = spheres_[2 * body + 1];
    const double at_a = offsets_[2 * body], at_b = offsets_[2 * body + 1];
    const double *const n = bodies.axis[body];
    double force[3], lever[3], *const net_force = bodies.force[body], *const net_torque = bodies.torque[body];
    for (int d = 0; d < 3; d++) {
      force[d] = f[a][d] + f[b][d] + bodies.mass[body] * gravity[d];
      lever[d] = at_a * f[a][d] + at_b * f[b][d];
      net_torque[d] = torque[a][d] + torque[b][d];
    }
    net_torque[0] += n[1] * lever[2] - n[2] * lever[1];
    net_torque[1] += n[2] * lever[0] - n[0] * lever[2];
    net_torque[2] += n[0] * lever[1] - n[1] * lever[0];
    std::copy(force, force + 3, net_force);
  }
  if (local_damping_ == 0.0) return;
  ClumpBatch &c = batch_;
  for (int first = 0; first < n_body(); first += ClumpBatch::SIZE) {
    const int count = std::min(ClumpBatch::SIZE + 0, n_body() - first);
    gather_motion(bodies, first, count);
    for (int k = 0; k < count; k++)
      for (int d = 0; d < 3; d++) c.spin[d][k] = bodies.spin[first + k][d];
    ballast::damp(c, local_damping_, ahead);
    for (int k = 0; k < count; k++)
      for (int d = 0; d < 3; d++) {
        bodies.force[first + k][d] = c.force[d][k];
        bodies.torque[first + k][d] = c.torque[d][k];
      }
  }
}

void FixMultisphereDamped::final_integrate() {
  calc_force(false);
  const Bodies bodies(data());
  ClumpBatch &c = batch_;
  for (int first = 0; first < n_body(); first += ClumpBatch::SIZE) {
    const int count = std::min(ClumpBatch::SIZE + 0, n_body() - first);
    gather_motion(bodies, first, count);
    ballast::kick(c, update->dt);
    for (int k = 0; k < count; k++)
      for (int d = 0; d < 3; d++) {
        bodies.velocity[first + k][d] = c.velocity[d][k];
        bodies.momentum[first + k][d] = c.momentum[d][k];
        bodies.spin[first + k][d] = c.spin[d][k];
      }
    set_spheres(first, count, false);
  }
  rev_comm_flag_ = MS_COMM_REV_V_OMEGA;
  reverse_comm();
  fw_comm_flag_ = MS_COMM_FW_V_OMEGA;
  forward_comm();
}

int FixMultisphereDamped::modify_param(int narg, char **arg) {
  if (strcmp(arg[0], "local_damping") != 0) return 0;
  if (narg < 2) ballast::stop_with_error(lmp, "fix_modify local_damping: value missing; give a number from 0 to 1");
  local_damping_ = force->numeric(FLERR, arg[1]);
  if (local_damping_ < 0.0 || local_damping_ >= 1.0)
    ballast::stop_with_error(lmp, "fix_modify local_damping: out of range; give a number from 0 to below 1");
  return 2;
}
