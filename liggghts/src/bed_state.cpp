#include "bed_state.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>

#include "atom.h"
#include "compute.h"
#include "contact_recorder.h"
#include "fix_bonds.h"
#include "fix_gravity.h"
#include "fix_multisphere.h"
#include "fix_wall.h"
#include "force.h"
#include "lammps.h"
#include "material.h"
#include "modify.h"
#include "pair_ballast.h"
#include "pair_gran.h"
#include "stop_with_error.h"

using namespace LAMMPS_NS;

namespace ballast {

ContactRecorder *ContactRecorder::active = NULL;

FixMultisphere *find_clumps(LAMMPS *lmp) {
  return dynamic_cast<FixMultisphere *>(lmp->modify->find_fix_style("multisphere", 0));
}

namespace {

/// Contacts of LIGGGHTS' own pair styles, which know no recorder: from the deck's `compute pairs all pair/gran/local
/// pos id force`.
void record_stock_pairs(LAMMPS *lmp, std::vector<Contact> &contacts) {
  const int number = lmp->modify->find_compute("pairs");
  if (number < 0)
    stop_with_error(lmp, "LIGGGHTS' own contact models need `compute pairs all pair/gran/local pos id force`");
  Compute &pairs = *lmp->modify->compute[number];
  pairs.compute_local();
  const double friction = read_material(lmp, PARTICLES, PARTICLES, false).friction;
  const Atom *atom = lmp->atom;
  for (int n = 0; n < pairs.size_local_rows; n++) {
    const double *const row = pairs.array_local[n], *const xi = row, *const xj = row + 3, *const force = row + 9;
    Contact c = {};
    c.i = lmp->atom->map(static_cast<int>(row[6]));
    c.j = lmp->atom->map(static_cast<int>(row[7]));
    double distance2 = 0.0, shear2 = 0.0;
    for (int d = 0; d < 3; d++) distance2 += (xi[d] - xj[d]) * (xi[d] - xj[d]);
    const double distance = std::sqrt(distance2);
    for (int d = 0; d < 3; d++) {
      c.normal[d] = (xi[d] - xj[d]) / distance;
      c.normal_force += force[d] * c.normal[d];
    }
    for (int d = 0; d < 3; d++) {
      c.shear[d] = force[d] - c.normal_force * c.normal[d];
      shear2 += c.shear[d] * c.shear[d];
    }
    c.overlap = atom->radius[c.i] + atom->radius[c.j] - distance;
    c.sliding = std::sqrt(shear2) >= (1.0 - 1e-9) * friction * std::fabs(c.normal_force) && shear2 > 0.0;
    contacts.push_back(c);
  }
}

}  // namespace

std::vector<Contact> collect_contacts(LAMMPS *lmp) {
  ContactRecorder recorder;
  ContactRecorder::active = &recorder;
  PairGran *pair = dynamic_cast<PairGran *>(lmp->force->pair);
  const bool stock =
      pair && pair->hashcode() != PairBallast::hashcode_of(false) && pair->hashcode() != PairBallast::hashcode_of(true);
  if (pair && !stock) pair->compute_pgl(0, 0);
  for (int n = 0; n < lmp->modify->nfix; n++)
    if (FixWall *wall = dynamic_cast<FixWall *>(lmp->modify->fix[n])) wall->record_contacts();
  ContactRecorder::active = NULL;

  const Atom *atom = lmp->atom;
  std::vector<Contact> counted;
  if (stock) record_stock_pairs(lmp, counted);
  for (const Contact &contact : recorder.contacts)
    if (contact.j < atom->nlocal || atom->tag[contact.i] < atom->tag[contact.j]) counted.push_back(contact);
  return counted;
}

namespace {

/// Mean kinetic energy per clump (or sphere), J.
double mean_kinetic_energy(LAMMPS *lmp, FixMultisphere *clumps, double &count) {
  double sums[2] = {0.0, 0.0};
  if (clumps) {
    Multisphere &bodies = clumps->data();
    double v[3], omega[3], momentum[3];
    for (int b = 0; b < bodies.n_body(); b++) {
      bodies.vcm(v, b);
      bodies.omega(omega, b);
      bodies.angmom(momentum, b);
      for (int d = 0; d < 3; d++) sums[0] += 0.5 * (bodies.mass(b) * v[d] * v[d] + omega[d] * momentum[d]);
    }
    sums[1] = bodies.n_body();
  } else {
    const Atom *atom = lmp->atom;
    for (int i = 0; i < atom->nlocal; i++)
      for (int d = 0; d < 3; d++) {
        const double spin = atom->omega[i][d] * atom->radius[i];
        sums[0] += 0.5 * atom->rmass[i] * (atom->v[i][d] * atom->v[i][d] + 0.4 * spin * spin);
      }
    sums[1] = atom->nlocal;
  }
  double all[2];
  MPI_Allreduce(sums, all, 2, MPI_DOUBLE, MPI_SUM, lmp->world);
  count = all[1];
  return count > 0 ? all[0] / count : 0.0;
}

/// Mean net force on a clump, N: contact forces and bonds of all ranks plus weight.
double mean_net_force(LAMMPS *lmp, FixMultisphere *clumps, const std::vector<Contact> &contacts) {
  const Atom *atom = lmp->atom;
  int highest = 0, highest_all;
  for (int i = 0; i < atom->nlocal; i++) highest = std::max(highest, clumps ? clumps->belongs_to(i) : atom->tag[i]);
  MPI_Allreduce(&highest, &highest_all, 1, MPI_INT, MPI_MAX, lmp->world);

  double gravity[3] = {0.0, 0.0, 0.0};
  if (FixGravity *weight = dynamic_cast<FixGravity *>(lmp->modify->find_fix_style("gravity", 0)))
    weight->get_gravity(gravity);
  std::vector<double> net(3 * (highest_all + 1), 0.0), net_all(net.size());
  std::vector<int> exists(highest_all + 1, 0), exists_all(exists.size());
  auto owner = [&](int i) { return clumps ? clumps->belongs_to(i) : atom->tag[i]; };
  auto add = [&](int body, const double *force, double factor) {
    for (int d = 0; d < 3; d++) net[3 * body + d] += factor * force[d];
  };
  if (clumps)
    for (int b = 0; b < clumps->n_body(); b++) {
      add(clumps->data().tag(b), gravity, clumps->data().mass(b));
      exists[clumps->data().tag(b)] = 1;
    }
  else
    for (int i = 0; i < atom->nlocal; i++) {
      add(atom->tag[i], gravity, atom->rmass[i]);
      exists[atom->tag[i]] = 1;
    }
  for (const Contact &contact : contacts) {
    double force[3];
    for (int d = 0; d < 3; d++) force[d] = contact.normal_force * contact.normal[d] + contact.shear[d];
    if (owner(contact.i) > 0) add(owner(contact.i), force, 1.0);
    if (contact.j >= 0 && owner(contact.j) > 0) add(owner(contact.j), force, -1.0);
  }
  if (const FixBonds *bonds = FixBonds::find(lmp))
    for (const FixBonds::Force &bond : bonds->forces()) {
      add(owner(bond.i), bond.value, 1.0);
      add(owner(bond.j), bond.value, -1.0);
    }
  MPI_Allreduce(net.data(), net_all.data(), static_cast<int>(net.size()), MPI_DOUBLE, MPI_SUM, lmp->world);
  MPI_Allreduce(exists.data(), exists_all.data(), static_cast<int>(exists.size()), MPI_INT, MPI_SUM, lmp->world);
  double sum = 0.0, count = 0.0;
  for (int body = 0; body <= highest_all; body++)
    if (exists_all[body]) {
      const double *f = &net_all[3 * body];
      sum += std::sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
      count++;
    }
  return count > 0 ? sum / count : 0.0;
}

}  // namespace

BedState evaluate_bed(LAMMPS *lmp) {
  FixMultisphere *clumps = find_clumps(lmp);
  const std::vector<Contact> contacts = collect_contacts(lmp);
  const double *radius = lmp->atom->radius;
  enum { COUNT, PAIRS, SLIDING, AT_LIMIT, OVERLAP, FORCE, SUMS };
  double sums[SUMS] = {}, all[SUMS], deepest = 0.0;
  for (const Contact &c : contacts) {
    double force2 = c.normal_force * c.normal_force;
    for (double component : c.shear) force2 += component * component;
    sums[COUNT] += 1.0;
    sums[PAIRS] += c.j >= 0;
    sums[SLIDING] += c.sliding;
    sums[AT_LIMIT] += c.j >= 0 && c.dashpot_at_limit;
    sums[OVERLAP] += c.overlap;
    sums[FORCE] += std::sqrt(force2);
    deepest = std::max(deepest, c.overlap / radius[c.i]);
  }
  MPI_Allreduce(sums, all, SUMS, MPI_DOUBLE, MPI_SUM, lmp->world);
  BedState state;
  MPI_Allreduce(&deepest, &state.overlap_max_ratio, 1, MPI_DOUBLE, MPI_MAX, lmp->world);
  state.kinetic_energy = mean_kinetic_energy(lmp, clumps, state.clumps);
  const double contact_count = std::max(1.0, all[COUNT]), mean_contact_force = all[FORCE] / contact_count;
  const double net_force = mean_net_force(lmp, clumps, contacts);
  // a bed without any contact force carries nothing: not balanced, unless nothing acts at all
  state.unbalanced_ratio =
      mean_contact_force > 0.0 ? net_force / mean_contact_force : (net_force > 0.0 ? INFINITY : 0.0);
  state.overlap_mean = all[OVERLAP] / contact_count;
  state.contacts = all[COUNT];
  state.at_limit_share = all[AT_LIMIT] / std::max(1.0, all[PAIRS]);
  state.sliding_share = all[SLIDING] / contact_count;
  return state;
}

}  // namespace ballast
