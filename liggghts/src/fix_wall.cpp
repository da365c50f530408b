#include "fix_wall.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "atom.h"
#include "comm.h"
#include "contact_recorder.h"
#include "error.h"
#include "force.h"
#include "material.h"
#include "memory.h"
#include "neighbor.h"
#include "restart_state.h"
#include "stop_with_error.h"
#include "update.h"

using namespace LAMMPS_NS;
using namespace FixConst;
using ballast::ContactBatch;
using ballast::ContactHistory;
using ballast::ContactRecorder;

namespace {

const int HISTORY = sizeof(ContactHistory) / sizeof(double);
const double EVERYWHERE = 1e300;
const double NO_LENGTH = 1e-150;  // m; its square is still a number

}  // namespace

FixWall::FixWall(LAMMPS *lmp, int narg, char **arg)
    : Fix(lmp, narg, arg),
      plane_axis_(-1),
      type_(ballast::WALLS),
      hysteretic_(false),
      friction_share_(1.0),
      constants_(),
      history_(NULL),
      built_(-1),
      contacts_(0) {
  std::fill(displacement_, displacement_ + 3, 0.0);
  std::fill(velocity_, velocity_ + 3, 0.0);
  std::fill(force_, force_ + 3, 0.0);
  for (int n = parse_shape(narg, arg); n < narg; n += 2) {
    const std::string key = arg[n], value = n + 1 < narg ? arg[n + 1] : "";
    if (key == "model" && (value == "linear" || value == "hysteretic"))
      hysteretic_ = value == "hysteretic";
    else if (key == "type" && !value.empty())
      type_ = force->inumeric(FLERR, arg[n + 1]);
    else if (key == "friction_share" && !value.empty())
      friction_share_ = force->numeric(FLERR, arg[n + 1]);
    else
      error->fix_error(FLERR, this, "after its shape expects model linear|hysteretic, type T and friction_share S");
  }
  if (!(friction_share_ >= 0.0 && friction_share_ <= 1.0))
    error->fix_error(FLERR, this, "friction_share must be 0 to 1");
  grow_arrays(atom->nmax);
  std::fill_n(history_, atom->nmax, ContactHistory());
  atom->add_callback(0);
  atom->add_callback(1);
  restart_global = 1;
  restart_peratom = 1;
  create_attribute = 1;
  vector_flag = 1;
  size_vector = 7;
  global_freq = 1;
  extvector = 0;
}

FixWall::~FixWall() {
  atom->delete_callback(id, 0);
  atom->delete_callback(id, 1);
  memory->sfree(history_);
}

int FixWall::parse_shape(int narg, char **arg) {
  std::fill(low_, low_ + 3, -EVERYWHERE);
  std::fill(high_, high_ + 3, EVERYWHERE);
  const std::string shape = narg > 3 ? arg[3] : "";
  if (shape == "xplane" || shape == "yplane" || shape == "zplane") plane_axis_ = shape[0] - 'x';
  const int numbers = plane_axis_ >= 0 ? 1 : 6;
  if ((plane_axis_ < 0 && shape != "block") || narg < 4 + numbers)
    error->fix_error(FLERR, this, "expects xplane|yplane|zplane POSITION, or block XLO XHI YLO YHI ZLO ZHI");
  if (plane_axis_ >= 0) {
    low_[plane_axis_] = high_[plane_axis_] = force->numeric(FLERR, arg[4]);
    return 4 + numbers;
  }
  for (int d = 0; d < 3; d++) {
    low_[d] = force->numeric(FLERR, arg[4 + 2 * d]);
    high_[d] = force->numeric(FLERR, arg[5 + 2 * d]);
    if (!(low_[d] < high_[d])) error->fix_error(FLERR, this, "block: each lower bound must lie below its upper bound");
  }
  return 4 + numbers;
}

int FixWall::setmask() { return POST_FORCE; }

void FixWall::init() {
  constants_ = ballast::read_material(lmp, ballast::PARTICLES, type_, hysteretic_);
  constants_.friction *= friction_share_;
}

void FixWall::setup(int vflag) {
  built_ = -1;
  post_force(vflag);
}

void FixWall::post_force(int) { evaluate_contacts(true, !update->setupflag); }

void FixWall::record_contacts() { evaluate_contacts(false, false); }

void FixWall::move(const double *step) {
  for (int d = 0; d < 3; d++) displacement_[d] += step[d];
}

void FixWall::set_velocity(const double *velocity) { std::copy(velocity, velocity + 3, velocity_); }

/// Vector from the wall's nearest point to x, and its length squared. side is -1 where x lies inside a block: its
/// nearest face then pushes it out.
double FixWall::gap(const double *x, double *distance, double &side) const {
  double length2 = 0.0;
  for (int d = 0; d < 3; d++) {
    const double above = x[d] - (high_[d] + displacement_[d]), below = x[d] - (low_[d] + displacement_[d]);
    // a plane touches from both sides
    distance[d] = above > 0.0 ? above : (below < 0.0 ? below : 0.0);
    length2 += distance[d] * distance[d];
  }
  side = 1.0;
  if (length2 > 0.0) return length2;
  if (plane_axis_ >= 0) {  // a centre on the plane itself
    distance[plane_axis_] = NO_LENGTH;
    return NO_LENGTH * NO_LENGTH;
  }
  side = -1.0;
  double depth = EVERYWHERE;
  for (int d = 0; d < 3; d++) {
    const double up = high_[d] + displacement_[d] - x[d], down = x[d] - (low_[d] + displacement_[d]);
    if (std::min(up, down) >= depth) continue;
    depth = std::max(std::min(up, down), NO_LENGTH);
    std::fill(distance, distance + 3, 0.0);
    distance[d] = up < down ? depth : -depth;
  }
  return depth * depth;
}

/// Spheres that may touch before the next neighbour list, or before the wall has moved by half a skin.
void FixWall::find_candidates() {
  candidates_.clear();
  double distance[3], side;
  for (int i = 0; i < atom->nlocal; i++) {
    const double reach = atom->radius[i] + neighbor->skin, length2 = gap(atom->x[i], distance, side);
    if (side < 0.0 || length2 <= reach * reach) candidates_.push_back(i);
  }
  std::copy(displacement_, displacement_ + 3, displacement_then_);
  built_ = neighbor->lastcall;
}

void FixWall::evaluate_contacts(bool compute, bool advance) {
  double moved2 = 0.0;
  for (int d = 0; d < 3; d++)
    moved2 += (displacement_[d] - displacement_then_[d]) * (displacement_[d] - displacement_then_[d]);
  if (built_ != neighbor->lastcall || moved2 > 0.25 * neighbor->skin * neighbor->skin) find_candidates();
  if (compute) {
    std::fill(force_, force_ + 3, 0.0);
    contacts_ = 0;
  }
  const double *const *const x = atom->x;
  const double *const radius = atom->radius;
  int touching[ContactBatch::SIZE], count = 0;
  for (const int i : candidates_) {
    double distance[3], side;
    const double length2 = gap(x[i], distance, side);
    if (side > 0.0 && length2 >= radius[i] * radius[i]) continue;
    for (int d = 0; d < 3; d++) batch_.distance[d][count] = distance[d];
    batch_.side[count] = side;
    touching[count++] = i;
    if (count < ContactBatch::SIZE) continue;
    finish_batch(touching, count, compute, advance);
    count = 0;
  }
  if (count) finish_batch(touching, count, compute, advance);
}

void FixWall::finish_batch(const int *spheres, int count, bool compute, bool advance) {
  ContactBatch &b = batch_;
  for (int k = 0; k < count; k++) {
    const int i = spheres[k];
    const ContactHistory &history = history_[i];
    for (int d = 0; d < 3; d++) {
      b.velocity[d][k] = atom->v[i][d] - velocity_[d];
      b.spin_i[d][k] = atom->omega[i][d];
      b.shear[d][k] = history.shear[d];
    }
    b.radius_i[k] = atom->radius[i];
    b.effective_mass[k] = atom->rmass[i];
    b.effective_radius[k] = 2.0 * atom->radius[i];
    b.last_touch_step[k] = history.last_touch_step;
    b.impact_speed[k] = history.impact_speed;
  }
  ballast::evaluate(constants_, b, static_cast<double>(update->ntimestep), update->dt, advance);

  if (ContactRecorder::active)
    for (int k = 0; k < count; k++) ContactRecorder::active->add(spheres[k], -1, b, k);
  if (advance)
    for (int k = 0; k < count; k++)
      history_[spheres[k]] = {b.last_touch_step[k], {b.shear[0][k], b.shear[1][k], b.shear[2][k]}, b.impact_speed[k]};
  if (!compute) return;
  contacts_ += count;
  for (int k = 0; k < count; k++)
    for (int d = 0; d < 3; d++) {
      atom->f[spheres[k]][d] += b.force[d][k];
      atom->torque[spheres[k]][d] -= b.arm_i[k] * b.turn[d][k];
      force_[d] -= b.force[d][k];
    }
}

void FixWall::total_force(double *force) {
  if (comm->nprocs == 1)
    std::copy(force_, force_ + 3, force);
  else
    MPI_Allreduce(force_, force, 3, MPI_DOUBLE, MPI_SUM, world);
}

int FixWall::total_contacts() {
  int all;
  MPI_Allreduce(&contacts_, &all, 1, MPI_INT, MPI_SUM, world);
  return all;
}

double FixWall::compute_vector(int n) {
  if (n == 6) return total_contacts();
  if (n >= 3) return displacement_[n - 3];
  double force[3];
  total_force(force);
  return force[n];
}

void FixWall::grow_arrays(int nmax) {
  history_ =
      static_cast<ContactHistory *>(memory->srealloc(history_, nmax * sizeof(ContactHistory), "ballast/wall:history"));
}

void FixWall::copy_arrays(int i, int j, int) { history_[j] = history_[i]; }

void FixWall::set_arrays(int i) { history_[i] = ContactHistory(); }

int FixWall::pack_exchange(int i, double *buffer) {
  std::memcpy(buffer, &history_[i], sizeof(ContactHistory));
  return HISTORY;
}

int FixWall::unpack_exchange(int i, double *buffer) {
  std::memcpy(&history_[i], buffer, sizeof(ContactHistory));
  return HISTORY;
}

// In the restart file a sphere that has never touched the wall takes one number: the length.

int FixWall::size_restart(int i) { return history_[i].last_touch_step == 0.0 ? 1 : 1 + HISTORY; }

int FixWall::maxsize_restart() { return 1 + HISTORY; }

int FixWall::pack_restart(int i, double *buffer) {
  buffer[0] = size_restart(i);
  std::memcpy(buffer + 1, &history_[i], (size_restart(i) - 1) * sizeof(double));
  return size_restart(i);
}

void FixWall::unpack_restart(int i, int nth) {
  const double *stored = atom->extra[i];
  for (int n = 0; n < nth; n++) stored += static_cast<int>(stored[0]);
  history_[i] = ContactHistory();
  std::memcpy(&history_[i], stored + 1, (static_cast<int>(stored[0]) - 1) * sizeof(double));
}

void FixWall::write_restart(FILE *file) {
  ballast::write_state(file, comm->me, {displacement_[0], displacement_[1], displacement_[2]});
}

void FixWall::restart(char *buffer) { std::memcpy(displacement_, buffer, sizeof(displacement_)); }

double FixWall::memory_usage() { return atom->nmax * sizeof(ContactHistory); }
