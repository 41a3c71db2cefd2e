# %% [markdown]
# # A flank modification with two objectives: Optuna
#
# Equidistant and radial offset of the flank: small contact pressure and small backlash. Trials are stored in
# SQLite, so that a killed study continues where it stopped. The first process here waits after every
# trial and is killed after eight of 24; the second computes the rest.

# %%
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import optuna

optuna.logging.set_verbosity(optuna.logging.WARNING)
folder = Path(tempfile.mkdtemp())
storage = f"sqlite:///{folder / 'trials.db'}"

# %%
WORK = """
import sys
import arcmin
import optuna

optuna.logging.set_verbosity(optuna.logging.WARNING)
design = arcmin.Design.template("tao2024")

def goals(trial):
    machine = design.replace({
        "disc.modification.equidistant_offset_um": trial.suggest_float("equidistant_um", 0, 15),
        "disc.modification.radial_offset_um": trial.suggest_float("radial_um", 0, 15),
    })
    result = arcmin.contact(machine, positions=8)
    # Interference is negative play, and no better than as much play.
    return result.max_pressure_mpa, abs(result.play_arcmin)

sampler = optuna.samplers.NSGAIISampler(population_size=8, seed=int(sys.argv[2]))
study = optuna.create_study(storage=sys.argv[1], study_name="offsets", sampler=sampler,
                            directions=["minimize", "minimize"], load_if_exists=True)
while len(study.get_trials(states=[optuna.trial.TrialState.COMPLETE])) < 24:
    study.optimize(goals, n_trials=1)
    print(len(study.trials), flush=True)
    sys.stdin.readline()
"""
COMPLETE = [optuna.trial.TrialState.COMPLETE]
first = subprocess.Popen(
    [sys.executable, "-c", WORK, storage, "1"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
)
for line in first.stdout:
    if int(line) == 8:
        first.kill()
        break
    first.stdin.write("go on\n")
    first.stdin.flush()
first.wait()
before = len(optuna.load_study(study_name="offsets", storage=storage).get_trials(states=COMPLETE))
print(f"{before} trials were kept")

# %%
second = [sys.executable, "-c", WORK, storage, "2"]
subprocess.run(second, check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
study = optuna.load_study(study_name="offsets", storage=storage)
done = study.get_trials(states=COMPLETE)
assert before == 8 and len(done) == 24
for trial in study.best_trials:
    print(
        {name: round(value, 2) for name, value in trial.params.items()},
        [round(value, 3) for value in trial.values],
    )

# %%
figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
axes.plot(*zip(*(trial.values for trial in done), strict=True), "o", color="#999999", label="trials")
axes.plot(
    *zip(*(trial.values for trial in study.best_trials), strict=True), "o", label="none is better in both"
)
axes.set(xlabel="largest pressure in MPa", ylabel="play or interference in ′")
axes.legend()
