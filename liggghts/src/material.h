// Constants of the contact laws: decks give them as `fix ID all property/global NAME peratomtypepair ...` (or scalar).
#ifndef BALLAST_MATERIAL_H
#define BALLAST_MATERIAL_H

#include "contact_batch.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace ballast {

/// Types of the decks.
enum { PARTICLES = 1, WALLS = 2 };

/// Constants of the law between two types:
///   normalStiffness, shearStiffness (N/m), dampingRatio, slipFriction, shearModulus (Pa), contactPoissonRatio,
///   nominalRestitution of the pair of types; scalars dampingMode (0, 1, 2 of eq. 16), and, where given, dashpotLimit
///   (share of critical damping that the hysteretic dashpot may reach, 1 without it) and dashpotMassShare (share of the
///   effective mass in dashpots, 1 without it).
/// Ends the run if one is missing or impossible.
ContactConstants read_material(LAMMPS_NS::LAMMPS *lmp, int type_a, int type_b, bool hysteretic);

}  // namespace ballast

#endif
