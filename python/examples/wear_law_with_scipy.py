# %% [markdown]
# # A wear law fitted to measured lost motion, with bands: SciPy
#
# The backlash at the output was measured at some hours. The wear coefficient of the coupled prediction is
# fitted by least squares; its variance gives the band of the forecast.

# %%
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

import arcmin

design = arcmin.Design.template("tao2024")
hours = np.array([300.0, 600.0, 900.0, 1200.0, 1500.0])


def increase(coefficient_mm2_per_n, at_hours):
    """Increase of the one-sided play in arcmin since new."""
    machine = design.replace({"wear.coupled.coefficient_mm2_per_n": float(coefficient_mm2_per_n)})
    end = float(max(at_hours))
    history = arcmin.wear(machine, joints="ideal", hours=end, points=10).tables["wear_history"]
    return np.interp(at_hours, history["hours"], history["play_arcmin"] - history["play_arcmin"][0])


# %%
# Readings of a machine with faster wear than the design assumes; scatter as of a laser interferometer.
truth = 1.2e-12
readings = increase(truth, hours) + np.random.default_rng(3).normal(0, 2e-4, len(hours))

fit = least_squares(
    lambda log: (increase(np.exp(log[0]), hours) - readings) / 2e-4,
    [np.log(8e-13)],
    diff_step=2e-3,
    x_scale=0.1,
)
freedom = len(hours) - 1
deviation = float(np.sqrt(np.linalg.inv(fit.jac.T @ fit.jac)[0, 0] * max(1.0, 2 * fit.cost / freedom)))
low, best, high = np.exp(fit.x[0] + np.array([-1, 0, 1]) * student.ppf(0.975, freedom) * deviation)
print(f"k = {best:.3e} mm²/N, 95 % band {low:.3e} to {high:.3e}; the readings were made with {truth:.1e}")
assert low < truth < high and high / low < 1.5

# %%
later = np.linspace(0, 3000, 13)
courses = [increase(k, later) for k in (low, best, high)]
forecast = [float(course[-1]) for course in courses]
print("after 3000 h: {1:.4f} arcmin, {0:.4f} to {2:.4f}".format(*forecast))
assert forecast[0] < forecast[1] < forecast[2]
figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
axes.fill_between(later, courses[0], courses[2], alpha=0.3, label="95 % band")
axes.plot(later, courses[1], label="fit")
axes.plot(hours, readings, "ko", markersize=3, label="readings")
axes.set(xlabel="hours", ylabel="increase of the play in ′")
axes.legend()
