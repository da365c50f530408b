#include "pair_ballast.h"

#include <algorithm>

#include "atom.h"
#include "clones.h"
#include "comm.h"
#include "contact_recorder.h"
#include "error.h"
#include "force.h"
#include "material.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "stop_with_error.h"
#include "update.h"
#include "utils.h"

using namespace LAMMPS_NS;

namespace ballast {

namespace {

// history of a pair in LIGGGHTS' neighbour list; the impact speed exists in the hysteretic law only
enum { LAST_TOUCH, SHEAR, IMPACT_SPEED = SHEAR + 3 };

/// Indices of the pairs whose spheres touch, in order; returns their number. `touching` has room for one more than
/// there are pairs. LIGGGHTS' table of positions is contiguous: sphere i begins at 3 i.
BALLAST_CLONES int find_touching(const double *x, const double *radius, const int *i, const int *j, int pairs,
                                 int *touching) {
  const int BLOCK = 64;
  double room[BLOCK];
  int count = 0;
  for (int first = 0; first < pairs; first += BLOCK) {
    const int number = std::min(BLOCK + 0, pairs - first);
#pragma omp simd
    for (int k = 0; k < number; k++) {
      const int a = i[first + k], b = j[first + k];
      const double dx = x[3 * a] - x[3 * b], dy = x[3 * a + 1] - x[3 * b + 1], dz = x[3 * a + 2] - x[3 * b + 2];
      const double reach = radius[a] + radius[b];
      room[k] = reach * reach - (dx * dx + dy * dy + dz * dz);
    }
    // written in any case, counted only where the spheres touch: no branch to guess
    for (int k = 0; k < number; k++) {
      touching[count] = first + k;
      count += room[k] > 0.0;
    }
  }
  return count;
}

}  // namespace

PairBallast::PairBallast(LAMMPS *lmp, bool hysteretic) : Pointers(lmp), hysteretic_(hysteretic), constants_() {
  for (double &side : batch_.side) side = 1.0;
}

PairBallast::~PairBallast() {}

int64_t PairBallast::hashcode_of(bool hysteretic) {
  return LIGGGHTS::Utils::generate_gran_hashcode(hysteretic ? HYSTERETIC_ID : LINEAR_ID, SLIP_ID, 0, 0, 0);
}

void PairBallast::settings(int narg, char **arg, LIGGGHTS::IContactHistorySetup *history) {
  if (narg > 0)
    stop_with_error(lmp, std::string("pair_style gran: ") + arg[0] + " is no setting of the ballast models");
  history->add_history_value("last_touch_step", "0");
  for (const char *name : {"shear_x", "shear_y", "shear_z"}) history->add_history_value(name, "1");
  if (hysteretic_) history->add_history_value("impact_speed", "0");
}

int PairBallast::get_history_offset(const std::string name) {
  if (name == "last_touch_step") return LAST_TOUCH;
  if (name == "impact_speed" && hysteretic_) return IMPACT_SPEED;
  return name == "shear_x" ? SHEAR : -1;
}

bool PairBallast::contact_match(const std::string type, const std::string model) {
  if (type == "model" || type == "normal") return model == (hysteretic_ ? "ballast/hysteretic" : "ballast/linear");
  return type == "tangential" && model == "ballast/slip";
}

void PairBallast::write_restart_settings(FILE *file) {
  const int64_t code = hashcode();
  fwrite(&code, sizeof(code), 1, file);
}

void PairBallast::read_restart_settings(FILE *file, int64_t) {
  if (comm->me != 0) return;
  int64_t code = -1;
  if (fread(&code, sizeof(code), 1, file) != 1 || code != hashcode())
    error->one(FLERR, "the restart file has another contact model");
}

void PairBallast::init_granular() {
  constants_ = read_material(lmp, PARTICLES, PARTICLES, hysteretic_);
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->type[i] != PARTICLES)
      error->one(FLERR, "the ballast models: all spheres must have type 1; type 2 is for walls");
}

void PairBallast::list_pairs(PairGran *pair) {
  const NeighList &list = *pair->list;
  const int width = pair->dnum();
  pairs_.i.clear();
  pairs_.j.clear();
  pairs_.history.clear();
  pairs_.flag.clear();
  for (int n = 0; n < list.inum; n++) {
    const int i = list.ilist[n];
    for (int m = 0; m < list.numneigh[i]; m++) {
      pairs_.i.push_back(i);
      pairs_.j.push_back(list.firstneigh[i][m] & NEIGHMASK);
      pairs_.history.push_back(pair->listgranhistory->firstdouble[i] + m * width);
      pairs_.flag.push_back(pair->listgranhistory->firstneigh[i] + m);
    }
  }
  touching_.resize(pairs_.i.size() + 1);
}

void PairBallast::compute_force(PairGran *pair, int, int, int) {
  // LIGGGHTS' virials are not computed: nothing in this study asks for them
  pair->evflag = pair->vflag_fdotr = 0;
  if (neighbor->ago == 0) list_pairs(pair);
  if (pairs_.i.empty()) return;
  const int count = find_touching(atom->x[0], atom->radius, pairs_.i.data(), pairs_.j.data(),
                                  static_cast<int>(pairs_.i.size()), touching_.data());
  const bool compute = pair->computeflag(), advance = compute && pair->shearupdate();
  for (int first = 0; first < count; first += ContactBatch::SIZE)
    add_forces(touching_.data() + first, std::min(ContactBatch::SIZE + 0, count - first), compute, advance);
}

/// touching are indices of pairs_.
void PairBallast::add_forces(const int *touching, int count, bool compute, bool advance) {
  const double *const x = atom->x[0], *const v = atom->v[0], *const omega = atom->omega[0];
  const double *const radius = atom->radius, *const mass = atom->rmass;
  ContactBatch &b = batch_;
  for (int k = 0; k < count; k++) {
    const int i = pairs_.i[touching[k]], j = pairs_.j[touching[k]];
    const double *const history = pairs_.history[touching[k]];
    for (int d = 0; d < 3; d++) {
      b.distance[d][k] = x[3 * i + d] - x[3 * j + d];
      b.velocity[d][k] = v[3 * i + d] - v[3 * j + d];
      b.spin_i[d][k] = omega[3 * i + d];
      b.spin_j[d][k] = omega[3 * j + d];
      b.shear[d][k] = history[SHEAR + d];
    }
    b.radius_i[k] = radius[i];
    b.radius_j[k] = radius[j];
    // clumps are alike: the division is for verification's unlike spheres
    b.effective_mass[k] = mass[i] == mass[j] ? 0.5 * mass[i] : mass[i] * mass[j] / (mass[i] + mass[j]);
    b.effective_radius[k] = radius[i] == radius[j] ? radius[i] : 2.0 * radius[i] * radius[j] / (radius[i] + radius[j]);
    b.last_touch_step[k] = history[LAST_TOUCH];
    if (hysteretic_) b.impact_speed[k] = history[IMPACT_SPEED];
  }
  evaluate(constants_, b, static_cast<double>(update->ntimestep), update->dt, advance);

  if (ContactRecorder::active)
    for (int k = 0; k < count; k++) ContactRecorder::active->add(pairs_.i[touching[k]], pairs_.j[touching[k]], b, k);
  if (advance)
    for (int k = 0; k < count; k++) {
      double *const history = pairs_.history[touching[k]];
      history[LAST_TOUCH] = b.last_touch_step[k];
      for (int d = 0; d < 3; d++) history[SHEAR + d] = b.shear[d][k];
      if (hysteretic_) history[IMPACT_SPEED] = b.impact_speed[k];
    }
  if (!compute) return;
  double *const f = atom->f[0], *const torque = atom->torque[0];
  const int nlocal = atom->nlocal;
  for (int k = 0; k < count; k++) {
    const int i = pairs_.i[touching[k]], j = pairs_.j[touching[k]];
    *pairs_.flag[touching[k]] = 1;
    for (int d = 0; d < 3; d++) {
      f[3 * i + d] += b.force[d][k];
      torque[3 * i + d] -= b.arm_i[k] * b.turn[d][k];
    }
    if (j >= nlocal) continue;
    for (int d = 0; d < 3; d++) {
      f[3 * j + d] -= b.force[d][k];
      torque[3 * j + d] -= b.arm_j[k] * b.turn[d][k];
    }
  }
}

}  // namespace ballast
