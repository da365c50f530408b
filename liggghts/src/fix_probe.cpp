#include "fix_probe.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "atom.h"
#include "bed_state.h"
#include "comm.h"
#include "error.h"
#include "fix_bonds.h"
#include "fix_multisphere_damped.h"
#include "force.h"
#include "stop_with_error.h"
#include "update.h"

using namespace LAMMPS_NS;
using namespace FixConst;

FixProbe::FixProbe(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg), file_(NULL), last_row_(-1) {
  if (narg != 5) error->fix_error(FLERR, this, "expects EVERY FILE");
  nevery = force->inumeric(FLERR, arg[3]);
  if (nevery < 1) error->fix_error(FLERR, this, "EVERY must be at least 1");
  if (comm->nprocs > 1) error->fix_error(FLERR, this, "works on one rank only");
  path_ = arg[4];
  file_ = fopen(path_.c_str(), "wb");
  if (!file_)
    error->one(FLERR, (path_ + ": cannot be written; make the folder and check free space and permissions").c_str());
}

FixProbe::~FixProbe() { fclose(file_); }

int FixProbe::setmask() { return END_OF_STEP; }

void FixProbe::post_run() {
  if (fflush(file_) != 0 || ferror(file_)) fail();
}

void FixProbe::fail() { ballast::stop_with_error(lmp, path_ + ": cannot be written; free disk space"); }

void FixProbe::setup(int) {
  if (last_row_ < 0) write_row();
}

void FixProbe::end_of_step() { write_row(); }

void FixProbe::write_row() {
  last_row_ = update->ntimestep;
  if (FixMultisphereDamped *clumps = dynamic_cast<FixMultisphereDamped *>(ballast::find_clumps(lmp)))
    clumps->update_spheres();
  std::vector<double> row(3, 0.0);
  for (const ballast::Contact &contact : ballast::collect_contacts(lmp)) {
    row[0] += 1.0;
    row[1] += contact.dashpot_at_limit;
  }
  if (FixBonds *bonds = FixBonds::find(lmp)) row[2] = bonds->compute_vector(1);
  std::vector<int> order(atom->nlocal);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [this](int a, int b) { return atom->tag[a] < atom->tag[b]; });
  for (int i : order)
    for (double *const *values : {atom->x, atom->v, atom->omega, atom->f, atom->torque})
      row.insert(row.end(), values[i], values[i] + 3);
  if (fwrite(row.data(), sizeof(double), row.size(), file_) != row.size()) fail();
}

int FixProbe::modify_param(int narg, char **arg) {
  if (strcmp(arg[0], "motion") != 0 || narg != 8)
    error->all(FLERR, "fix_modify ballast/probe: expects motion CLUMP VX VY VZ WX WY WZ");
  FixMultisphere *clumps = ballast::find_clumps(lmp);
  if (!clumps) error->all(FLERR, "fix_modify ballast/probe motion: there are no clumps");
  const int body = clumps->data().map(force->inumeric(FLERR, arg[1]));
  if (body < 0) error->all(FLERR, "fix_modify ballast/probe motion: there is no such clump");
  double velocity[3], spin[3];
  for (int d = 0; d < 3; d++) {
    velocity[d] = force->numeric(FLERR, arg[2 + d]);
    spin[d] = force->numeric(FLERR, arg[5 + d]);
  }
  clumps->data().set_v_body(body, velocity);
  clumps->data().set_angmom_via_omega_body(body, spin);
  return 8;
}
