# %% [markdown]
# # Distribution of the pin forces: a plot with Matplotlib
#
# Columns of a table are NumPy arrays with the unit at the end of their name, for use in any plotting package.

# %%
import matplotlib.pyplot as plt

import arcmin

design = arcmin.Design.template("tao2024")
result = arcmin.contact(design, torque_nm=412, positions=36)
contact = result.tables["contact"]

# %%
first = (contact["crank_angle_deg"] == 0) & (contact["force_n"] > 0)
figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
for disc in sorted(set(contact["disc"][first].tolist())):
    of_disc = first & (contact["disc"] == disc)
    axes.plot(contact["meshing_angle_deg"][of_disc], contact["force_n"][of_disc], "o", label=f"disc {disc}")
axes.set(xlabel="meshing angle in °", ylabel="force of a pin in N", title="Crank at 0°, 412 N·m")
axes.legend()

# %%
# The largest force of the plot is close to that of the summary, which includes further crank positions.
largest = float(contact["force_n"].max())
assert 0.98 * result.max_force_n < largest <= 1.02 * result.max_force_n
largest
