// What the bed does at this moment: contacts, energies, overlaps. Evaluated on demand, never per step.
#ifndef BALLAST_BED_STATE_H
#define BALLAST_BED_STATE_H

#include <vector>

#include "contact_recorder.h"

namespace LAMMPS_NS {
class LAMMPS;
class FixMultisphere;
}  // namespace LAMMPS_NS

namespace ballast {

/// Values over all ranks, SI units.
struct BedState {
  double kinetic_energy;      ///< J, mean per clump, translation and rotation
  double unbalanced_ratio;  ///< mean net force on a clump (with gravity, without local damping) over mean contact force
  double overlap_max_ratio;  ///< greatest overlap over the radius of its sphere
  double overlap_mean;  ///< m
  double contacts;  ///< particle-particle and particle-wall
  double clumps;
  double at_limit_share;  ///< of particle-particle contacts: hysteretic dashpot at its cap
  double sliding_share;  ///< of all contacts
};

/// The deck's fix multisphere, or null for single spheres.
LAMMPS_NS::FixMultisphere *find_clumps(LAMMPS_NS::LAMMPS *lmp);

/// Every contact this rank has to count; a contact of two ranks belongs to the one that owns the sphere of the lower
/// tag. Forces are those of the last step; nothing is advanced. Collective.
std::vector<Contact> collect_contacts(LAMMPS_NS::LAMMPS *lmp);

/// Collective.
BedState evaluate_bed(LAMMPS_NS::LAMMPS *lmp);

}  // namespace ballast

#endif
