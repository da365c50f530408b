#include "pair_ballast.h"

#include "atom.h"
#include "comm.h"
#include "contact_recorder.h"
#include "error.h"
#include "force.h"
#include "material.h"
#include "neigh_list.h"
#include "stop_with_error.h"
#include "update.h"
#include "utils.h"

using namespace LAMMPS_NS;

namespace ballast {

namespace {

// history of a pair in LIGGGHTS' neighbour list; the impact speed exists in the hysteretic law only
enum { LAST_TOUCH, SHEAR, IMPACT_SPEED = SHEAR + 3 };

}  // namespace

PairBallast::PairBallast(LAMMPS *lmp, bool hysteretic) : Pointers(lmp), hysteretic_(hysteretic), constants_() {
  for (double &side : batch_.side) side = 1.0;
}

PairBallast::~PairBallast() {}

int64_t PairBallast::hashcode_of(bool hysteretic) {
  return LIGGGHTS::Utils::generate_gran_hashcode(hysteretic ? HYSTERETIC_ID : LINEAR_ID, SLIP_ID, 0, 0, 0);
}

void PairBallast::settings(int narg, char **arg, LIGGGHTS::IContactHistorySetup *history) {
  if (narg > 0) stop_with_error(lmp, std::string("pair_style gran: ") + arg[0] + " is no setting of the ballast models");
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
  if (fread(&code, sizeof(code), 1, file) != 1 || code != hashcode()) error->one(FLERR, "the restart file has another contact model");
}

void PairBallast::init_granular() {
  constants_ = read_material(lmp, PARTICLES, PARTICLES, hysteretic_);
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->type[i] != PARTICLES) error->one(FLERR, "the ballast models: all spheres must have type 1; type 2 is for walls");
}

void PairBallast::compute_force(PairGran *pair, int, int, int) {
  // LIGGGHTS' virials are not computed: nothing in this study asks for them
  pair->evflag = pair->vflag_fdotr = 0;
  if (atom->nlocal == 0) return;
  const double *const x = atom->x[0];  // LIGGGHTS' tables of vectors are contiguous: sphere i begins at 3 i
  const double *const radius = atom->radius;
  const NeighList &list = *pair->list;
  int *const *const flags = pair->listgranhistory->firstneigh;
  double *const *const histories = pair->listgranhistory->firstdouble;
  const int width = pair->dnum();
  const bool compute = pair->computeflag(), advance = compute && pair->shearupdate();

  Touching touching[ContactBatch::SIZE];
  int count = 0;
  for (int n = 0; n < list.inum; n++) {
    const int i = list.ilist[n];
    const double xi = x[3 * i], yi = x[3 * i + 1], zi = x[3 * i + 2], radius_i = radius[i];
    const int *const neighbours = list.firstneigh[i];
    int *const flags_i = flags[i];
    double *const histories_i = histories[i];
    const int number = list.numneigh[i];
    for (int m = 0; m < number; m++) {
      const int j = neighbours[m] & NEIGHMASK;
      const double dx = xi - x[3 * j], dy = yi - x[3 * j + 1], dz = zi - x[3 * j + 2], reach = radius_i + radius[j];
      // written in any case, counted only where the spheres touch: no branch to guess
      touching[count] = {i, j, histories_i + m * width, flags_i + m};
      count += dx * dx + dy * dy + dz * dz < reach * reach;
      if (count < ContactBatch::SIZE) continue;
      add_forces(touching, count, compute, advance);
      count = 0;
    }
  }
  if (count) add_forces(touching, count, compute, advance);
}

void PairBallast::add_forces(const Touching *touching, int count, bool compute, bool advance) {
  const double *const x = atom->x[0], *const v = atom->v[0], *const omega = atom->omega[0];
  const double *const radius = atom->radius, *const mass = atom->rmass;
  ContactBatch &b = batch_;
  for (int k = 0; k < count; k++) {
    const int i = touching[k].i, j = touching[k].j;
    const double *const history = touching[k].history;
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
    for (int k = 0; k < count; k++) ContactRecorder::active->add(touching[k].i, touching[k].j, b, k);
  if (advance)
    for (int k = 0; k < count; k++) {
      double *const history = touching[k].history;
      history[LAST_TOUCH] = b.last_touch_step[k];
      for (int d = 0; d < 3; d++) history[SHEAR + d] = b.shear[d][k];
      if (hysteretic_) history[IMPACT_SPEED] = b.impact_speed[k];
    }
  if (!compute) return;
  double *const f = atom->f[0], *const torque = atom->torque[0];
  const int nlocal = atom->nlocal;
  for (int k = 0; k < count; k++) {
    const int i = touching[k].i, j = touching[k].j;
    *touching[k].flag = 1;
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
