#include "tangential_model_ballast_slip.h"
