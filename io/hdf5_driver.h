#pragma once

#include <hdf5.h>

namespace samara::io::hdf5 {

/// Makes an access list open files by our own read-only driver: it reads what is asked for, refuses whatever
/// lies outside the file, and has none of the library's caches above drivers, which trust addresses and
/// sizes in damaged files. Inside a Session.
/// @returns whether it could
bool use_guarded_driver(hid_t access);

}  // namespace samara::io::hdf5
