// While a recorder is switched on, pairs and walls hand it every contact they evaluate: contact output and bed state
// come from the same code path as the forces.
#ifndef BALLAST_CONTACT_RECORDER_H
#define BALLAST_CONTACT_RECORDER_H

#include <vector>

#include "contact_batch.h"

namespace ballast {

/// One contact of sphere i (local) with sphere j (local or ghost; -1 for a wall).
struct Contact {
  int i, j;
  double normal[3];        ///< unit vector from the partner to sphere i
  double overlap;          ///< m
  double normal_force;     ///< N, with dashpot
  double shear[3];         ///< shear force on sphere i, N
  bool sliding;
  bool dashpot_at_limit;
};

class ContactRecorder {
 public:
  /// The recorder switched on, or null in ordinary steps.
  static ContactRecorder *active;

  /// Contact k of the batch, of sphere i with j (-1 for a wall).
  void add(int i, int j, const ContactBatch &b, int k) {
    contacts.push_back({i,
                        j,
                        {b.normal[0][k], b.normal[1][k], b.normal[2][k]},
                        b.overlap[k],
                        b.normal_force[k],
                        {b.shear[0][k], b.shear[1][k], b.shear[2][k]},
                        b.sliding[k] != 0.0,
                        b.dashpot_at_limit[k] != 0.0});
  }

  std::vector<Contact> contacts;
};

}  // namespace ballast

#endif
