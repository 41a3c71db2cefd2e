# %% [markdown]
# # Many designs on a cluster of local workers: Dask
#
# Designs and results can be pickled. For thousands of results, return only the values that are needed.

# %%
from dask.distributed import Client, LocalCluster

import arcmin

design = arcmin.Design.template("tao2024")
eccentricities = [1.2, 1.25, 1.3, 1.35]
designs = [design.replace({"crankshafts.eccentricity_mm": value}) for value in eccentricities]


def largest_force(machine):
    return arcmin.contact(machine, positions=12, threads=1).max_force_n


# %%
if __name__ == "__main__":
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        forces = client.gather(client.map(largest_force, designs))
        whole = client.submit(arcmin.profile, design, points=20).result()
    assert forces == [largest_force(machine) for machine in designs]
    assert whole.tables["profile"].rows == 39 * 20
    for value, force in zip(eccentricities, forces, strict=True):
        print(f"{value:.2f} mm: {force:.1f} N")
