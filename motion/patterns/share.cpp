#include "samara/motion/patterns/share.h"

#include <boost/math/special_functions/beta.hpp>

#include "samara/base/require.h"

namespace samara::motion {

Share counted_share(long count, long total) {
  require(total > 0, "total", total, "at least 1");
  require(count >= 0 && count <= total, "count", count, "0 to the total");
  const double a = static_cast<double>(count) + 0.5, b = static_cast<double>(total - count) + 0.5;
  Share share = {static_cast<double>(count) / static_cast<double>(total)};
  if (count > 0) share.lower = boost::math::ibeta_inv(a, b, 0.025);
  if (count < total) share.upper = boost::math::ibeta_inv(a, b, 0.975);
  return share;
}

}  // namespace samara::motion
