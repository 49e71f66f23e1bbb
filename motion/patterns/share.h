#pragma once

namespace samara::motion {

/// A share that was counted, with its 95 % interval.
struct Share {
  double value = 0.0;
  double lower = 0.0, upper = 1.0;
};

/// `count` of `total`, as if each were drawn by itself: the interval of the beta distribution of (count + 1/2,
/// total - count + 1/2), which ends at 0 where nothing was counted and at 1 where everything was (L. D. Brown,
/// T. T. Cai, A. DasGupta, Statist. Sci. 16 (2001) 101-133: Jeffreys' interval). Neighbours on a grid are not drawn
/// by themselves: then it is too narrow.
/// @throws ArgumentError unless 0 <= count <= total and total > 0.
Share counted_share(long count, long total);

}  // namespace samara::motion
