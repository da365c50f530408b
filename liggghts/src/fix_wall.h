#ifndef BALLAST_FIX_WALL_H
#define BALLAST_FIX_WALL_H

#include <vector>

#include "contact_batch.h"
#include "fix.h"

namespace LAMMPS_NS {

/// A wall that spheres touch: a plane, or an axis-parallel block. No triangles: a sphere has one contact with a block,
/// at the point of it that is nearest to the sphere's centre, on a face, an edge or a corner.
///   fix ID all ballast/wall xplane|yplane|zplane POSITION model linear|hysteretic type T
///   fix ID all ballast/wall block XLO XHI YLO YHI ZLO ZHI model linear|hysteretic type T
/// The law and its constants are those of the pairs (gran model ballast/...), between types 1 and T. Shear history is
/// kept per sphere, and displacement and history in restart files. `fix ballast/load` moves a wall. Outputs: [1]-[3]
/// contact force on the wall (N), [4]-[6] displacement from the deck's place (m), [7] contacts.
class FixWall : public Fix {
 public:
  FixWall(class LAMMPS *, int, char **);
  ~FixWall() override;
  int setmask() override;
  void init() override;
  void setup(int) override;
  void post_force(int) override;
  double compute_vector(int) override;

  /// Contact force of all ranks on the wall in the last step, N. Collective.
  void total_force(double *force);
  /// Spheres of all ranks in contact. Collective.
  int total_contacts();
  /// Displace the wall by so much, m.
  void move(const double *step);
  /// For relative velocities at contacts, m/s; moves nothing.
  void set_velocity(const double *velocity);
  /// Hand all contacts to the recorder that is switched on; nothing is advanced.
  void record_contacts();

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
  double memory_usage() override;

 private:
  int parse_shape(int narg, char **arg);
  void find_candidates();
  double gap(const double *x, double *distance, double &side) const;
  void evaluate_contacts(bool compute, bool advance);
  void finish_batch(const int *spheres, int count, bool compute, bool advance);

  int plane_axis_;                       // -1 for a block
  double low_[3], high_[3];  // of the deck; the bounds of a plane are one along its axis and infinite along the others
  double displacement_[3], velocity_[3];
  int type_;
  bool hysteretic_;
  double friction_share_;
  ballast::ContactConstants constants_;
  ballast::ContactBatch batch_;

  ballast::ContactHistory *history_;  // one per sphere
  std::vector<int> candidates_;  // spheres near the wall, ascending
  double displacement_then_[3];  // of the wall when they were looked for
  bigint built_;  // neighbour list they belong to, -1 = none
  double force_[3];  // this rank's
  int contacts_;  // this rank's
};

}  // namespace LAMMPS_NS

#endif
