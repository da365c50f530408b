#ifndef BALLAST_FIX_BED_STATE_H
#define BALLAST_FIX_BED_STATE_H

#include "bed_state.h"
#include "fix.h"

namespace LAMMPS_NS {

/// `fix ID all ballast/state`: the state of the bed for decks; costs nothing until it is asked.
/// Outputs: [1] kinetic energy per clump (J), [2] unbalanced ratio, [3] greatest overlap over radius, [4] mean overlap
/// (m), [5] contacts, [6] clumps, [7] share of dashpots at their limit, [8] share of sliding contacts.
class FixBedState : public Fix {
 public:
  FixBedState(class LAMMPS *, int, char **);
  int setmask() override { return 0; }
  void setup(int) override { step_ = -1; }
  double compute_vector(int) override;
  /// State at the present step. Collective.
  const ballast::BedState &state();

 private:
  bigint step_;               // of state_, -1 = none
  ballast::BedState state_;
};

}  // namespace LAMMPS_NS

#endif
