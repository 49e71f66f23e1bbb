#include "inputs/model_libraries.h"

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

#include <dlfcn.h>
#include <elf.h>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/models/laws/model_library.h"
#include "samara/models/laws/registry.h"

namespace samara::apps {

namespace {

/// A function of the library; null if it has none of this name.
template <class Function>
Function find_function(void* library, const char* name) {
  return reinterpret_cast<Function>(dlsym(library, name));
}

/// The loader dies of a file that is shorter than its header says.
bool is_whole(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  Elf64_Ehdr header = {};
  file.read(reinterpret_cast<char*>(&header), sizeof header);
  if (!file || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) return true;  // the loader says what it is
  std::error_code ignored;
  const std::uintmax_t end = header.e_shoff + std::uintmax_t{header.e_shnum} * header.e_shentsize;
  return std::filesystem::file_size(path, ignored) >= end;
}

void load(const std::string& path) {
  if (!is_whole(path)) throw InputError(path, "is cut short: it ends before its table of sections does");
  // An absolute path: the loader would look for a plain name in the folders of the system.
  std::error_code unknown;
  void* library = dlopen(std::filesystem::absolute(path, unknown).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) throw InputError(path, fmt::format("cannot be loaded: {}", dlerror()));
  const auto interface = find_function<const char* (*)()>(library, "samara_model_interface");
  const auto add_models = find_function<void (*)(models::AddModel)>(library, "samara_add_models");
  if (interface == nullptr || add_models == nullptr)
    throw InputError(path, "is no library of models: SAMARA_MODEL_LIBRARY stands in none of its sources");
  if (std::string_view(interface()) != models::kModelInterface)
    throw InputError(path, fmt::format("was compiled for \"{}\", expected \"{}\": compile it again",
                                       interface(), models::kModelInterface));
  add_models(models::add_model);
}

}  // namespace

void load_model_libraries(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) load(path);  // never closed: models live as long as the program
}

}  // namespace samara::apps
