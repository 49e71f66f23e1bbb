#include "options/command_pages.h"

#include <algorithm>

#include <fmt/format.h>

namespace samara::apps {

namespace {

constexpr std::array<CommandPage, 28> kPages = {{
    {"models", {"samara models", "samara models vertical_fall"}, "docs/models.md"},
    {"simulate",
     {"samara simulate falling_plate_nd --until 20 -o plate.csv",
      "samara simulate immersed_body --set a=3.5cm --set b=2cm --set c=0.1mm --set density=1200 --until \"2 "
      "s\" --forces"},
     "docs/models.md"},
    {"plan",
     {"samara plan vertical_fall > plan.toml", "samara plan falling_plate_nd -o plate.toml"},
     "docs/plans.md"},
    {"build",
     {"samara build plan.toml -o coin.h5",
      "samara build plan.toml -o coin.h5 --tolerance 1e-5 --set C_D=0.8..1.4"},
     "docs/plans.md"},
    {"info", {"samara info coin.h5", "samara info coin.h5 --plan > plan.toml"}, "docs/queries.md"},
    {"stats",
     {"samara stats coin.h5 --set v0=0.1 --quantiles 0.05 0.95",
      "samara stats coin.h5 --set \"C_D=normal(1.17, 0.1)\" --json"},
     "docs/statistics.md"},
    {"query",
     {"samara query coin.h5 --set C_D=1.15 --set v0=10cm/s --at 0:0.1:0.5 --gradient",
      "samara query coin.h5 --points points.csv -o answers.csv"},
     "docs/queries.md"},
    {"export",
     {"samara export rod.h5 --to paraview --set conductivity=40 --at \"1 min\" -o rod.vtu",
      "samara export wake.h5 --to paraview -o wake.xdmf"},
     "docs/queries.md"},
    {"explore",
     {"samara explore coin.h5 -o coin.html",
      "samara explore coin.h5 --capture coin.toml --fit fit.json -o coin.html"},
     "docs/explore.md"},
    {"plot",
     {"samara plot coin.h5 --set C_D=1.2 -o coin.svg", "samara plot fit.json --of profiles -o profiles.svg"},
     "docs/explore.md"},
    {"validate",
     {"samara validate coin.h5 --points 5000 --seed 7", "samara validate pendulum.h5 --plan pendulum.toml"},
     "docs/certificate.md"},
    {"fit",
     {"samara fit coin.h5 drops.toml --config fit.toml -o fit.json --report fit.html",
      "samara fit coin.h5 --coefficients fit.json --left-out a.csv b.csv --left-out-span \"0.2 s\" --ahead "
      "\"0.1 s\""},
     "docs/fitting.md"},
    {"body",
     {"samara body plate --size \"10 cm\" \"7 cm\" \"0.4 mm\" --density 1200 --fluid 1.2",
      "samara body leaf.stl --unit mm --density \"0.7 g/cm^3\" --fluid 1.2 --toml"},
     "docs/bodies.md"},
    {"design",
     {"samara design coin.h5 --fit fit.json --captures 4",
      "samara design coin.h5 --fit fit.json --for C_D --times 5"},
     "docs/next_experiment.md"},
    {"compare",
     {"samara compare plain.toml wake.toml --model falling_plate falling_plate_with_wake --left-out "
      "drops.toml --by drop",
      "samara compare free.toml held.toml --model coin.h5 --left-out drops.toml --by drop --json"},
     "docs/comparisons.md"},
    {"follow",
     {"samara follow vertical_fall fit.json drop.csv --ahead \"0.1 s\"",
      "samara follow vertical_fall fit.json drop.csv --train a.csv b.csv -o followed.csv"},
     "docs/following.md"},
    {"wind",
     {"samara wind wind.toml", "samara wind wind.toml --at \"0, 0, 2 m\" --until \"10 min\" -o series.csv"},
     "docs/wind.md"},
    {"flow",
     {"samara flow square.toml -o wake.h5", "samara flow square.toml -o wake.h5 --fresh"},
     "docs/flow.md"},
    {"picture",
     {"samara picture wake.h5 -o k.png", "samara picture wake.h5 --field speed --scale 4 -o speed.png"},
     "docs/flow.md"},
    {"sweep",
     {"samara sweep sweep.toml -o card.h5", "samara sweep sweep.toml -o card.h5 --json"},
     "docs/pattern_maps.md"},
    {"database",
     {"samara database card.h5 -o motions.h5", "samara database card.h5 -o motions.h5 --json"},
     "docs/motion.md"},
    {"patterns",
     {"samara patterns card.h5", "samara patterns falls.csv --length \"7 cm\" --json"},
     "docs/filmed_patterns.md"},
    {"regime",
     {"samara regime falling_plate --set semi_chord=1cm --set semi_thickness=0.5mm --set density=2700",
      "samara regime falling_plate --set semi_chord=1cm --set semi_thickness=0.5mm --set density=2700 "
      "--json"},
     "docs/patterns.md"},
    {"synthesize",
     {"samara synthesize motion.toml -o fall.glb",
      "samara synthesize motion.toml -o fall.csv --course course.h5 --picture fall.svg"},
     "docs/synthesis.md"},
    {"ghost",
     {"samara ghost falling_plate fall.csv --coefficients course.h5",
      "samara ghost falling_plate fall.csv --coefficients course.h5 --json -o ghost.csv"},
     "docs/synthesis.md"},
    {"completion",
     {"source <(samara completion bash)", "samara completion fish > ~/.config/fish/completions/samara.fish"},
     "docs/reference/commands.md"},
    {"help", {"samara help query", "samara help build --man | man -l -"}, "docs/reference/commands.md"},
    {"",
     {"samara plan vertical_fall > plan.toml", "samara build plan.toml -o coin.h5"},
     "docs/reference/commands.md"},
}};

}  // namespace

const CommandPage* page_of(std::string_view command) {
  const auto* const found = std::ranges::find(kPages, command, &CommandPage::command);
  return found == kPages.end() ? nullptr : found;
}

std::string footer_of(std::string_view command) {
  const CommandPage* page = page_of(command);
  if (page == nullptr) return "";
  return fmt::format("Examples:\n  {}\n  {}\nMore: {}", page->examples[0], page->examples[1], page->page);
}

}  // namespace samara::apps
