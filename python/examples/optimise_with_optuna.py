# %% [markdown]
# # A modification for two goals: Optuna
#
# Equidistant and radial offset of the flank: small contact pressure against small play. Trials are kept in
# SQLite; a study that was killed goes on where it stopped, which the last cell shows.

# %%
import subprocess
import sys
import tempfile
from pathlib import Path

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
"""
first = subprocess.Popen([sys.executable, "-c", WORK, storage, "1"], stdout=subprocess.PIPE, text=True)
for line in first.stdout:
    if int(line) >= 8:
        first.kill()
        break
first.wait()
before = len(
    optuna.load_study(study_name="offsets", storage=storage).get_trials(
        states=[optuna.trial.TrialState.COMPLETE]
    )
)

# %%
subprocess.run([sys.executable, "-c", WORK, storage, "2"], check=True, stdout=subprocess.DEVNULL)
study = optuna.load_study(study_name="offsets", storage=storage)
done = study.get_trials(states=[optuna.trial.TrialState.COMPLETE])
assert 8 <= before < len(done) == 24
for trial in study.best_trials:
    print(
        {name: round(value, 2) for name, value in trial.params.items()},
        [round(value, 3) for value in trial.values],
    )
