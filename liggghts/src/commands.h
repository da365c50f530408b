// Commands that decks of this study may use beside those of LIGGGHTS.
#ifndef BALLAST_COMMANDS_H
#define BALLAST_COMMANDS_H

namespace LAMMPS_NS {
class LAMMPS;
}

namespace ballast {

/// place_clumps FILE radius R half_distance H mass M density RHO inertia TRANSVERSE AXIAL type T
/// Clumps of two spheres at the poses of a bed file, at rest; ids are those of the file.
void place_clumps(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// delete_clumps outside XLO XHI YLO YHI ZLO ZHI
/// Marks clumps whose centre is outside; they are gone after the setup of the next run (`run 0` suffices).
void delete_clumps(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// write_bed FILE: poses of all clumps, in the order of their ids.
void write_bed(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// write_contacts FILE: all contacts with their forces.
void write_contacts(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// write_bonds FILE: all bonds, broken ones too; where they are, or broke.
void write_bonds(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// write_state FILE STAGE: append one row of the bed's state.
void write_state_row(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// write_checkpoint FILE: a restart file that appears complete, or not at all.
void write_checkpoint(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// stop_requested NAME: set the variable NAME to 1 if SIGTERM or SIGINT came to any rank, else to 0.
void stop_requested(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// end_run CODE: leave with this exit status.
void end_run(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

/// fail TEXT: print `ERROR: TEXT` and leave with exit status 1.
void fail(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);

}  // namespace ballast

#endif
