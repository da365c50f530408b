#ifndef BALLAST_REGISTRATION_H
#define BALLAST_REGISTRATION_H

namespace LAMMPS_NS {
class LAMMPS;
}

namespace ballast {

/// Add the contact models to LIGGGHTS' factories.
void register_contact_models();

/// Add the fixes and commands to one LIGGGHTS instance.
void register_styles(LAMMPS_NS::LAMMPS *lmp);

}  // namespace ballast

#endif
