#include "samara/motion/patterns/share.h"

#include "samara/base/require.h"
#include "samara/identification/statistics/quantiles.h"

namespace samara::motion {

Share counted_share(long count, long total) {
  require(total > 0, "total", total, "at least 1");
  require(count >= 0 && count <= total, "count", count, "0 to the total");
  const double a = static_cast<double>(count) + 0.5, b = static_cast<double>(total - count) + 0.5;
  Share share = {static_cast<double>(count) / static_cast<double>(total)};
  if (count > 0) share.lower = identification::beta_quantile(a, b, 0.025);
  if (count < total) share.upper = identification::beta_quantile(a, b, 0.975);
  return share;
}

}  // namespace samara::motion
