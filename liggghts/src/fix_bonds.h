#ifndef BALLAST_FIX_BONDS_H
#define BALLAST_FIX_BONDS_H

#include <vector>

#include "bond_law.h"
#include "fix.h"

namespace LAMMPS_NS {

/// Parallel bonds between spheres of different clumps (bond_law.h), beside their contacts.
///   fix ID all ballast/bonds per_area|total radius MULTIPLIER stiffness NORMAL SHEAR strength NORMAL SHEAR
/// per_area: Pa/m and Pa; total: N/m and N. The spheres that touch at the setup of the first run are bonded; later
/// nothing is. Every sphere keeps its own bonds, broken ones too, so that they move with it from rank to rank and into
/// the restart file. A bond whose spheres belong to two ranks is computed on both, with the same numbers. Outputs: [1]
/// bonds made, [2] bonds that hold, [3] broken in tension, [4] broken in shear.
class FixBonds : public Fix {
 public:
  /// One bond as the sphere of index i sees it.
  struct Bond {
    double partner;             ///< tag of the other sphere
    double fate;                ///< BondFate
    ballast::BondState state;   ///< body 1 is the sphere of the lower tag
    double broken_step;         ///< steps since the bonds were made
    double broken_at[3];        ///< m
  };
  /// A bond's force on sphere i (local), from sphere j (local or ghost).
  struct Force {
    int i, j;
    double value[3];
  };
  /// One bond for output.
  struct Row {
    int i, j;                   ///< local, and local or ghost
    double place[3];
    Bond bond;
    double tensile_stress, shear_stress;
  };

  FixBonds(class LAMMPS *, int, char **);
  ~FixBonds() override;
  /// The deck's bonds, or null.
  static FixBonds *find(class LAMMPS *);
  int setmask() override;
  void init() override;
  void setup(int) override;
  void post_force(int) override;
  double compute_vector(int) override;

  /// Forces at this moment; each bond is counted once over all ranks.
  std::vector<Force> forces() const;
  /// All bonds, broken ones too; each is counted once over all ranks.
  std::vector<Row> rows() const;

  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override;
  int maxsize_restart() override;
  void write_restart(FILE *) override;
  void restart(char *) override;

 private:
  void make();
  void drop_deleted();
  void compute(bool advance);
  ballast::BondMotion motion(int a, int b) const;
  int partner_of(const Bond &bond) const;
  /// True where this rank counts the bond of its sphere i.
  bool counts(int i, const Bond &bond) const { return atom_tag(i) < bond.partner; }
  int atom_tag(int i) const;

  ballast::BondConstants constants_;
  std::vector<std::vector<Bond>> bonds_;   // of each local sphere
  bigint made_step_;                        // -1 = not yet
  bigint spheres_;                          // of all ranks when deleted ones were last looked for
};

}  // namespace LAMMPS_NS

#endif
