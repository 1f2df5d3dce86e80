#include <cstdlib>
#include <string>

#include "splat/base/error.h"
#include "splat/train/ranks/ranks.h"

namespace cosplat {

std::shared_ptr<Ranks> JoinRanks() {
  const char* ranks = std::getenv("OMPI_COMM_WORLD_SIZE");  // set by Open MPI's mpirun
  if (!ranks || std::string(ranks) == "1") return OneRank();
#if defined(COSPLAT_HAS_MPI)
  return JoinMpi();
#else
  throw Error("mpirun",
              "started " + std::string(ranks) + " ranks, but this program was built without MPI");
#endif
}

}  // namespace cosplat
