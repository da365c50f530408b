#include "fix_bonds.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <tuple>

#include "atom.h"
#include "bed_state.h"
#include "comm.h"
#include "error.h"
#include "fix_multisphere.h"
#include "force.h"
#include "modify.h"
#include "restart_state.h"
#include "stop_with_error.h"
#include "update.h"

using namespace LAMMPS_NS;
using namespace FixConst;
using namespace ballast;

namespace {

const int WIDTH = sizeof(FixBonds::Bond) / sizeof(double);
const int MOST_BONDS = 30;  // of one sphere; twelve equal ones fit around it

}  // namespace

FixBonds::FixBonds(LAMMPS *lmp, int narg, char **arg)
    : Fix(lmp, narg, arg), constants_(), made_step_(-1), spheres_(-1) {
  const std::string reading = narg > 3 ? arg[3] : "";
  if (narg != 12 || (reading != "per_area" && reading != "total") || strcmp(arg[4], "radius") != 0 ||
      strcmp(arg[6], "stiffness") != 0 || strcmp(arg[9], "strength") != 0)
    error->fix_error(FLERR, this,
                     "expects per_area|total radius MULTIPLIER stiffness NORMAL SHEAR strength NORMAL SHEAR");
  constants_ = {force->numeric(FLERR, arg[5]),  force->numeric(FLERR, arg[7]),  force->numeric(FLERR, arg[8]),
                force->numeric(FLERR, arg[10]), force->numeric(FLERR, arg[11]), reading == "total"};
  grow_arrays(atom->nmax);
  atom->add_callback(0);
  atom->add_callback(1);
  restart_global = 1;
  restart_peratom = 1;
  create_attribute = 1;
  vector_flag = 1;
  size_vector = 4;
  global_freq = 1;
  extvector = 0;
}

FixBonds::~FixBonds() {
  atom->delete_callback(id, 0);
  atom->delete_callback(id, 1);
}

FixBonds *FixBonds::find(LAMMPS *lmp) {
  for (int n = 0; n < lmp->modify->nfix; n++)
    if (FixBonds *bonds = dynamic_cast<FixBonds *>(lmp->modify->fix[n])) return bonds;
  return NULL;
}

int FixBonds::setmask() { return POST_FORCE; }

void FixBonds::init() {
  if (atom->map_style == 0) error->fix_error(FLERR, this, "needs atom_modify map array");
}

void FixBonds::setup(int) {
  if (made_step_ < 0) make();
  if (spheres_ != atom->natoms) drop_deleted();
  compute(false);
}

void FixBonds::post_force(int) { compute(true); }

int FixBonds::atom_tag(int i) const { return atom->tag[i]; }

/// Bond the spheres of different clumps that touch. Cells as wide as the largest sphere find them.
void FixBonds::make() {
  made_step_ = update->ntimestep;
  spheres_ = atom->natoms;
  const int all = atom->nlocal + atom->nghost;
  double widest = 0.0;
  for (int i = 0; i < all; i++) widest = std::max(widest, 2.0 * atom->radius[i]);
  if (widest == 0.0) return;
  typedef std::tuple<int, int, int> Cell;
  auto cell_of = [&](const double *x) {
    return Cell(static_cast<int>(std::floor(x[0] / widest)), static_cast<int>(std::floor(x[1] / widest)),
                static_cast<int>(std::floor(x[2] / widest)));
  };
  std::map<Cell, std::vector<int>> cells;
  for (int i = 0; i < all; i++) cells[cell_of(atom->x[i])].push_back(i);
  FixMultisphere *clumps = find_clumps(lmp);
  auto body = [&](int i) { return clumps ? clumps->belongs_to(i) : atom->tag[i]; };
  for (int i = 0; i < atom->nlocal; i++) {
    const Cell here = cell_of(atom->x[i]);
    for (int n = 0; n < 27; n++) {
      const auto near = cells.find(
          Cell(std::get<0>(here) + n / 9 - 1, std::get<1>(here) + n / 3 % 3 - 1, std::get<2>(here) + n % 3 - 1));
      if (near == cells.end()) continue;
      for (const int j : near->second) {
        // a sphere that is local is found as such, not as its own ghost
        if (atom->map(atom->tag[j]) != j || body(i) == body(j)) continue;
        const bool first = atom->tag[i] < atom->tag[j];
        const BondMotion m = motion(first ? i : j, first ? j : i);
        if (m.distance >= atom->radius[i] + atom->radius[j]) continue;
        bonds_[i].push_back({static_cast<double>(atom->tag[j]),
                             HOLDS,
                             {m.distance, {0.0, 0.0, 0.0}, 0.0, {0.0, 0.0, 0.0}},
                             -1.0,
                             {0.0, 0.0, 0.0}});
      }
    }
    if (bonds_[i].size() > static_cast<std::size_t>(MOST_BONDS))
      error->one(FLERR, "fix ballast/bonds: a sphere touches too many others");
    std::sort(bonds_[i].begin(), bonds_[i].end(), [](const Bond &a, const Bond &b) { return a.partner < b.partner; });
  }
  const double made = compute_vector(0);
  if (comm->me == 0 && screen) fprintf(screen, "%.0f bonds between clumps that touch\n", made);
}

/// Bonds to spheres that are no more go too. Collective.
void FixBonds::drop_deleted() {
  spheres_ = atom->natoms;
  const int highest = atom->tag_max();
  std::vector<char> mine(highest + 1, 0), exists(highest + 1, 0);
  for (int i = 0; i < atom->nlocal; i++) mine[atom->tag[i]] = 1;
  MPI_Allreduce(mine.data(), exists.data(), highest + 1, MPI_CHAR, MPI_MAX, world);
  for (int i = 0; i < atom->nlocal; i++) {
    std::vector<Bond> &list = bonds_[i];
    list.erase(std::remove_if(
                   list.begin(), list.end(),
                   [&](const Bond &bond) { return bond.partner > highest || !exists[static_cast<int>(bond.partner)]; }),
               list.end());
  }
}

int FixBonds::partner_of(const Bond &bond) const {
  const int j = atom->map(static_cast<int>(bond.partner));
  if (j < 0)
    error->one(FLERR,
               "fix ballast/bonds: a bonded sphere is out of this rank's reach; raise the deck's `communicate cutoff`");
  return j;
}

BondMotion FixBonds::motion(int a, int b) const {
  BondMotion m;
  double apart[3];
  for (int d = 0; d < 3; d++) {
    apart[d] = atom->x[a][d] - atom->x[b][d];
    m.velocity[d] = atom->v[a][d] - atom->v[b][d];
    m.spin_1[d] = atom->omega[a][d];
    m.spin_2[d] = atom->omega[b][d];
  }
  m.distance = std::sqrt(dot(apart, apart));
  for (int d = 0; d < 3; d++) m.normal[d] = apart[d] / m.distance;
  const double overlap = atom->radius[a] + atom->radius[b] - m.distance;
  m.arm_1 = atom->radius[a] - 0.5 * overlap;
  m.arm_2 = atom->radius[b] - 0.5 * overlap;
  return m;
}

void FixBonds::compute(bool advance) {
  const int nlocal = atom->nlocal;
  for (int i = 0; i < nlocal; i++) {
    for (Bond &bond : bonds_[i]) {
      if (bond.fate != HOLDS) continue;
      const int j = partner_of(bond);
      const bool first = atom->tag[i] < atom->tag[j];
      if (j < nlocal && !first) continue;  // done from the other side
      const int a = first ? i : j, b = first ? j : i;
      const BondMotion m = motion(a, b);
      const BondDisc disc = bond_disc(constants_, atom->radius[a], atom->radius[b]);
      if (advance) advance_bond(disc, bond.state, m, update->dt);
      const BondLoad load = bond_load(disc, bond.state, m);
      if (advance) bond.fate = bond_fate(disc, load);
      if (bond.fate != HOLDS) {
        bond.broken_step = static_cast<double>(update->ntimestep - made_step_);
        for (int d = 0; d < 3; d++) bond.broken_at[d] = 0.5 * (atom->x[a][d] + atom->x[b][d]);
      }
      if (j < nlocal)
        for (Bond &other : bonds_[j])
          if (other.partner == atom->tag[i]) {
            const double partner = other.partner;
            other = bond;
            other.partner = partner;
          }
      if (bond.fate != HOLDS) continue;
      double turn[3];
      cross(m.normal, load.force, turn);
      for (int d = 0; d < 3; d++) {
        if (a < nlocal) {
          atom->f[a][d] += load.force[d];
          atom->torque[a][d] += load.moment[d] - m.arm_1 * turn[d];
        }
        if (b < nlocal) {
          atom->f[b][d] -= load.force[d];
          atom->torque[b][d] -= load.moment[d] + m.arm_2 * turn[d];
        }
      }
    }
  }
}

std::vector<FixBonds::Force> FixBonds::forces() const {
  std::vector<Force> found;
  for (const Row &row : rows())
    if (row.bond.fate == HOLDS) {
      const BondMotion m = motion(row.i, row.j);
      const BondLoad load =
          bond_load(bond_disc(constants_, atom->radius[row.i], atom->radius[row.j]), row.bond.state, m);
      found.push_back({row.i, row.j, {load.force[0], load.force[1], load.force[2]}});
    }
  return found;
}

std::vector<FixBonds::Row> FixBonds::rows() const {
  std::vector<Row> found;
  for (int i = 0; i < atom->nlocal; i++)
    for (const Bond &bond : bonds_[i]) {
      if (!counts(i, bond)) continue;
      Row row = {i, -1, {bond.broken_at[0], bond.broken_at[1], bond.broken_at[2]}, bond, 0.0, 0.0};
      if (bond.fate == HOLDS) {
        row.j = partner_of(bond);
        const BondLoad load =
            bond_load(bond_disc(constants_, atom->radius[i], atom->radius[row.j]), bond.state, motion(i, row.j));
        row.tensile_stress = load.tensile_stress;
        row.shear_stress = load.shear_stress;
        for (int d = 0; d < 3; d++) row.place[d] = 0.5 * (atom->x[i][d] + atom->x[row.j][d]);
      }
      found.push_back(row);
    }
  return found;
}

double FixBonds::compute_vector(int n) {
  double mine = 0.0, all;
  for (int i = 0; i < atom->nlocal; i++)
    for (const Bond &bond : bonds_[i]) mine += counts(i, bond) && (n == 0 || bond.fate == n - 1);
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, world);
  return all;
}

void FixBonds::grow_arrays(int nmax) { bonds_.resize(nmax); }

void FixBonds::copy_arrays(int i, int j, int) {
  if (i != j) bonds_[j] = bonds_[i];
}

void FixBonds::set_arrays(int i) { bonds_[i].clear(); }

int FixBonds::pack_exchange(int i, double *buffer) {
  buffer[0] = static_cast<double>(bonds_[i].size());
  std::memcpy(buffer + 1, bonds_[i].data(), bonds_[i].size() * sizeof(Bond));
  return 1 + WIDTH * static_cast<int>(bonds_[i].size());
}

int FixBonds::unpack_exchange(int i, double *buffer) {
  bonds_[i].resize(static_cast<std::size_t>(buffer[0]));
  std::memcpy(bonds_[i].data(), buffer + 1, bonds_[i].size() * sizeof(Bond));
  return 1 + WIDTH * static_cast<int>(bonds_[i].size());
}

// In the restart file the length comes first.

int FixBonds::size_restart(int i) { return 1 + WIDTH * static_cast<int>(bonds_[i].size()); }

int FixBonds::maxsize_restart() { return 1 + WIDTH * MOST_BONDS; }

int FixBonds::pack_restart(int i, double *buffer) {
  buffer[0] = size_restart(i);
  std::memcpy(buffer + 1, bonds_[i].data(), bonds_[i].size() * sizeof(Bond));
  return size_restart(i);
}

void FixBonds::unpack_restart(int i, int nth) {
  const double *stored = atom->extra[i];
  for (int n = 0; n < nth; n++) stored += static_cast<int>(stored[0]);
  bonds_[i].resize((static_cast<int>(stored[0]) - 1) / WIDTH);
  std::memcpy(bonds_[i].data(), stored + 1, bonds_[i].size() * sizeof(Bond));
}

void FixBonds::write_restart(FILE *file) {
  write_state(file, comm->me, {static_cast<double>(made_step_), static_cast<double>(spheres_)});
}

void FixBonds::restart(char *buffer) {
  const double *state = reinterpret_cast<double *>(buffer);
  made_step_ = static_cast<bigint>(state[0]);
  spheres_ = static_cast<bigint>(state[1]);
}
