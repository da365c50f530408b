// While a recorder is switched on, the contact models hand it every contact they evaluate: contact output and bed state come from the
// same code path as the forces.
#ifndef BALLAST_CONTACT_RECORDER_H
#define BALLAST_CONTACT_RECORDER_H

#include <vector>

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

  void add(const Contact &contact) { contacts.push_back(contact); }

  std::vector<Contact> contacts;
};

}  // namespace ballast

#endif
