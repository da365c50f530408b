// `pair_style gran model ballast/linear tangential ballast/slip` and `... model ballast/hysteretic ...`: the paper's
// contact laws between particles, normal and shear force in one loop.
#ifndef BALLAST_PAIR_BALLAST_H
#define BALLAST_PAIR_BALLAST_H

#include <mpi.h>

#include <string>
#include <vector>

// LIGGGHTS' headers need this order
#include "lammps.h"
#include "pointers.h"
#include "pair_gran.h"
#include "granular_pair_style.h"

#include "contact_batch.h"

namespace ballast {

/// Ids of the models in LIGGGHTS' tables; 40 and 41 are free there.
enum { LINEAR_ID = 40, HYSTERETIC_ID = 41, SLIP_ID = 40 };

/// Takes the place of LIGGGHTS' own pair loop for these models; neighbour lists, contact history and restart stay its
/// own.
class PairBallast : public LIGGGHTS::PairStyles::IGranularPairStyle, protected LAMMPS_NS::Pointers {
 public:
  PairBallast(LAMMPS_NS::LAMMPS *lmp, bool hysteretic);
  ~PairBallast() override;

  void settings(int narg, char **arg, LIGGGHTS::IContactHistorySetup *history) override;
  void init_granular() override;
  void compute_force(LAMMPS_NS::PairGran *pair, int eflag, int vflag, int addflag) override;
  void write_restart_settings(FILE *file) override;
  void read_restart_settings(FILE *file, int64_t hashcode) override;
  int get_history_offset(const std::string name) override;
  double stressStrainExponent() override { return hysteretic_ ? 1.5 : 1.0; }
  int64_t hashcode() override { return hashcode_of(hysteretic_); }
  bool contact_match(const std::string type, const std::string model) override;

  static int64_t hashcode_of(bool hysteretic);

 private:
  /// Pairs of neighbours in the order of LIGGGHTS' list: local indices, history, and LIGGGHTS' flag that the history is
  /// to be kept.
  struct Pairs {
    std::vector<int> i, j;
    std::vector<double *> history;
    std::vector<int *> flag;
  };

  void list_pairs(LAMMPS_NS::PairGran *pair);
  void add_forces(const int *touching, int count, bool compute, bool advance);

  bool hysteretic_;
  ContactConstants constants_;
  ContactBatch batch_;
  Pairs pairs_;  // of the present neighbour list
  std::vector<int> touching_;  // which of them touch in this step
};

}  // namespace ballast

#endif
