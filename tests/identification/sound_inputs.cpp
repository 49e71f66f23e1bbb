#include "sound_inputs.h"

std::vector<SoundInput> sound_inputs() {
  const std::string rows = "0,0,1.5\n0.1,0.02,1.4\n0.2,0.05,1.3\n0.3,0.09,\n0.4,0.15,1.1\n0.5,0.2,1\n";
  const std::string table = "# body: coin\nt[s],x[cm],theta[deg]\n" + rows;
  const std::string sidecar =
      "file = \"cells.csv\"\ngroup_by = [\"drop\"]\nframe_rate = \"60 Hz\"\nfrom = \"0 s\"\nleast_frames = "
      "3\nflip = [\"x\"]\n"
      "where = { drop = [\"1\", \"2\"] }\ndelimiter = \";\"\ndecimal = \",\"\n[columns]\nframe = { quantity "
      "= \"t\", unit = "
      "\"frame\" }\ny_px = { quantity = \"x\", unit = \"px\" }\n[scale]\nx = { length = \"38 cm\", over = "
      "\"largest - first\" "
      "}\n[clean]\noutliers = 5\nlongest_gap = \"0.2 s\"\n[labels]\nfile = \"labels.csv\"\ncolumn = "
      "\"drop\"\n";
  std::string cells = "drop;frame;y_px\n";
  for (int k = 0; k < 20; ++k)
    cells += std::to_string(1 + k / 10) + ";" + std::to_string(k % 10) + ";" +
             std::to_string(10 + k * k % 37) + ",5\n";
  const std::string motive =
      "Format Version,1.23,Take Name,fall,Capture Frame Rate,120,Rotation Type,Quaternion,Length "
      "Units,Meters\n\n"
      ",Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body\n"
      ",Name,card,card,card,card,card,card,card\n,ID,1,1,1,1,1,1,1\n"
      ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position\n"
      "Frame,Time "
      "(Seconds),X,Y,Z,W,X,Y,Z\n0,0,0,0,0,1,0.1,1.5,0.2\n1,0.01,0,0,0.1,0.995,0.1,1.4,0.2\n2,0.02,0,0,0.2,0."
      "98,0.1,"
      "1.3,0.2\n3,0.03,,,,,,,\n";
  const std::string units = "length_unit = \"cm\"\ntime_unit = \"ms\"\n";
  const std::string condition = "conditionId\tv\nslow\t2\nfast\tv_fast\n";
  std::string measured = "observableId\tsimulationConditionId\tmeasurement\ttime\tnoiseParameters\n";
  for (int k = 1; k < 8; ++k)
    for (const char* name : {"slow", "fast"})
      measured += std::string("speed\t") + name + "\t" + std::to_string(5 - 0.5 * k) + "\t" +
                  std::to_string(0.1 * k) + "\t0.01\n";
  return {
      {"plan",
       {{"plan.toml", R"toml(model = "vertical_fall"
title = "a coin in water"
[fixed]
density = "6.339 g/cm^3"
thickness = "2.55 mm"
"x(0)" = "-5 cm"
[box]
C_D = [0.8, 1.6]
area = { range = ["4.5 cm^2", 4.9e-4], nodes = 9 }
"v(0)" = ["0 m/s", "30 cm/s"]
[time]
end = "500 ms"
[tolerance]
relative = 1e-4
absolute = { x = "1 um", v = 1e-5 }
[builder]
kind = "pgd"
strategy = "slabs"
max_calls = 100000
threads = 2
seed = 7
)toml"}},
       {0},
       "plan.toml"},
      {"plan",
       {{"plan.toml", R"toml(model = "heat_rod"
[fixed]
length = "10 cm"
[box]
conductivity = { range = [20.0, 60.0], transform = "log" }
left = ["20 degC", "80 degC"]
right = [300.0, 350.0]
amplitude = [-20.0, 20.0]
[time]
end = "10 min"
[tolerance]
relative = 1e-3
)toml"}},
       {0},
       "plan.toml"},
      {"plan",
       {{"plan.toml", R"toml(title = "own"
[equations]
name = "decay"
[equations.states]
n = { initial = 1.0 }
[equations.parameters]
k = { unit = "1/s" }
[equations.rates]
n = "-k*n"
[box]
k = [0.5, 2.0]
"n(0)" = [0.9, 1.1]
[time]
end = 3.0
)toml"}},
       {0},
       "plan.toml"},
      {"plan",
       {{"plan.toml", R"toml([command]
run = ["true"]
inputs = { x = "m", y = "1" }
outputs = { u = "N" }
timeout = "2 s"
[box]
x = [1.0, 2.0]
[fixed]
y = 0.5
)toml"}},
       {0},
       "plan.toml"},
      {"csv", {{"drop.csv", table}}, {0}, "drop.csv"},
      {"csv",
       {{"cells.csv", cells}, {"cells.toml", sidecar}, {"labels.csv", "drop,spin\n1,20\n2,30\n"}},
       {0, 2},
       "cells.toml"},
      {"sidecar",
       {{"cells.toml", sidecar}, {"cells.csv", cells}, {"labels.csv", "drop,spin\n1,20\n2,30\n"}},
       {0},
       "cells.toml"},
      {"sidecar",
       {{"pose.toml",
         "file = \"pose.csv\"\nup = \"-z\"\n[columns]\nt = { quantity = \"t\", unit = \"s\" }\np1 = { "
         "quantity = \"x\", unit = \"m\" "
         "}\np2 = { quantity = \"y\", unit = \"m\" }\np3 = { quantity = \"z\", unit = \"m\" "
         "}\n[attitude]\neuler = [\"a\", \"b\", "
         "\"c\"]\norder = \"zyx\"\nunit = \"deg\"\n"},
        {"pose.csv", "t,p1,p2,p3,a,b,c\n0,1,2,3,4,5,6\n1,1,2,4,4,6,6\n2,1,3,4,4,7,6\n3,1,3,4,9,7,6\n"}},
       {0},
       "pose.toml"},
      {"export",
       {{"ball.txt", "Ball 1;;\nt;x;y\n0,0;1,5;-2,5E-1\n0,1;2,5;0\n0,2;3,5;0\n0,3;4,5;1\n"},
        {"ball.toml", units}},
       {0},
       "ball.txt"},
      {"export",
       {{"kinovea.csv",
         "\"Time\";\"b/0/X\";\"b/0/"
         "Y\"\n\"0\";\"1,5\";\"10\"\n\"40\";\"2,5\";\"9,5\"\n\"80\";\"3,5\";\"9\"\n"},
        {"kinovea.toml", units}},
       {0},
       "kinovea.csv"},
      {"export",
       {{"tracks.txt",
         "#Kinovea Trajectory data export\n#T X Y\n\n# ball\n0 866.00 320.00\n20 847,5 321.00\n40 830 "
         "322\n\n# arm\n0 1 2\n20 3 4\n40 5 6\n"},
        {"tracks.toml", units}},
       {0},
       "tracks.txt"},
      {"export", {{"card.csv", motive}}, {0}, "card.csv"},
      {"petab",
       {{"problem.yaml",
         "format_version: 1\nparameter_file: parameters.tsv\nproblems:\n- condition_files: "
         "[conditions.tsv]\n  measurement_files:\n  - "
         "measurements.tsv\n  observable_files:\n  - observables.tsv\n  sbml_files: []\n"},
        {"parameters.tsv",
         "parameterId\tparameterScale\tlowerBound\tupperBound\tnominalValue\testimate\tobjectivePriorType\tob"
         "jectivePriorParameters\n"
         "rate\tlog10\t0.1\t5\t1\t1\tnormal\t1.2;0.3\nv_fast\tlin\t0.5\t9\t3\t0\t\t\n"},
        {"observables.tsv",
         "observableId\tobservableFormula\tnoiseFormula\nspeed\tv\tnoiseParameter1_speed\n"},
        {"conditions.tsv", condition},
        {"measurements.tsv", measured}},
       {0, 1, 2, 3, 4},
       "problem.yaml"},
  };
}

std::string sound_source() {
  return R"toml(title = "what falls, and slows down"
[equations]
name = "slowing"
[equations.states]
x = { unit = "m" }
y = { unit = "m", initial = 1.0 }
z = { unit = "m" }
theta = { unit = "rad" }
v = { unit = "m/s", initial = 2.0 }
[equations.parameters]
rate = { unit = "1/s" }
[equations.rates]
x = "v"
y = "-rate*y"
z = "v"
theta = "rate"
v = "-rate*v"
[box]
rate = [0.1, 5.0]
"v(0)" = [0.0, 9.0]
[time]
end = 3.0
[tolerance]
relative = 1e-3
)toml";
}
