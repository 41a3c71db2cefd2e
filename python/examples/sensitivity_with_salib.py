# %% [markdown]
# # Sensitivity of the contact pressure: SALib with arcmin's sampler
#
# `arcmin.sample` has the layouts of `arcmin study`; the kind "saltelli" is the layout for SALib's Sobol
# analysis. The indices have confidence intervals for this number of points.

# %%
import matplotlib.pyplot as plt
import numpy as np
from SALib.analyze import sobol

import arcmin

design = arcmin.Design.template("tao2024")
factors = {
    "disc.width_mm": {"low": 8.0, "high": 9.5},
    "ring.pin_radius_mm": {"low": 2.98, "high": 3.02},
    "crankshafts.eccentricity_mm": {"low": 1.25, "high": 1.35},
}
points = arcmin.sample(factors, 16, kind="saltelli", seed=7)
points.shape


# %%
def pressure(point):
    machine = design.replace(dict(zip(factors, point, strict=True)))
    return arcmin.contact(machine, positions=8).max_pressure_mpa


pressures = np.array([pressure(point) for point in points])

# %%
problem = {
    "num_vars": len(factors),
    "names": list(factors),
    "bounds": [[factor["low"], factor["high"]] for factor in factors.values()],
}
indices = sobol.analyze(problem, pressures, calc_second_order=False, seed=1)
for name, total, band in zip(factors, indices["ST"], indices["ST_conf"], strict=True):
    print(f"{name:30} {total:6.3f} ± {band:.3f}")
figure, axes = plt.subplots(figsize=(6, 2), layout="constrained")
axes.barh(list(factors), indices["ST"], xerr=indices["ST_conf"], color="#7fb3d5")
axes.set(xlabel="total index of the largest pressure")
