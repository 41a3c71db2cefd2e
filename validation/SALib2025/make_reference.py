"""Reference values for sampling statistics: SALib 1.6 and scipy 1.17.

The samples are written as well, so that both programs evaluate the same numbers:
    python make_reference.py        (needs SALib==1.6.*, scipy)
writes reference.json beside itself.
"""

import json
import pathlib

import numpy as np
from SALib.analyze import morris as analyze_morris
from SALib.analyze import sobol as analyze_sobol
from SALib.sample import morris as sample_morris
from SALib.sample import sobol as sample_sobol
from SALib.test_functions import Ishigami, Sobol_G
from scipy import optimize, stats


def sobol(name, function, problem, n, second_order):
    x = sample_sobol.sample(problem, n, calc_second_order=second_order, seed=1)
    y = function(x)
    s = analyze_sobol.analyze(problem, y, calc_second_order=second_order, seed=2)
    d = problem["num_vars"]
    record = {
        "name": name,
        "dimensions": d,
        "second_order": second_order,
        "results": y.tolist(),
        "first": s["S1"].tolist(),
        "total": s["ST"].tolist(),
        "first_half_width": s["S1_conf"].tolist(),
        "total_half_width": s["ST_conf"].tolist(),
    }
    if second_order:
        record["second"] = [s["S2"][i, j] for i in range(d) for j in range(i + 1, d)]
    return record


def morris(name, function, problem, n, levels):
    x = sample_morris.sample(problem, n, num_levels=levels, seed=3)
    y = function(x)
    s = analyze_morris.analyze(problem, x, y, num_levels=levels, seed=4)
    low, high = np.array(problem["bounds"]).T
    return {
        "name": name,
        "levels": levels,
        "units": ((x - low) / (high - low)).tolist(),
        "results": y.tolist(),
        "mu": list(map(float, s["mu"])),
        "mu_star": list(map(float, s["mu_star"])),
        "sigma": list(map(float, s["sigma"])),
        "mu_star_half_width": list(map(float, s["mu_star_conf"])),
    }


def clopper_pearson():
    rows = []
    cases = [(0, 10, 0.95), (3, 10, 0.95), (95, 100, 0.95), (57, 59, 0.9), (9721, 10000, 0.99), (100, 100, 0.95)]
    for kept, of, confidence in cases:
        ends = stats.binomtest(kept, of).proportion_ci(confidence, method="exact")
        rows.append({"kept": kept, "of": of, "confidence": confidence, "low": ends.low, "high": ends.high})
    return rows


def weibull(seed, count, shape, scale, until):
    rng = np.random.default_rng(seed)
    life = scale * rng.weibull(shape, count)
    ended = life < until
    hours = np.minimum(life, until)
    data = stats.CensoredData(uncensored=hours[ended], right=hours[~ended])

    def negative(shape, scale):
        law = stats.weibull_min(shape, scale=scale)
        return -(law.logpdf(hours[ended]).sum() + law.logsf(hours[~ended]).sum())

    # The tolerance of scipy's fit is 1e-4; Nelder–Mead continues from there to rounding.
    c, _, s = stats.weibull_min.fit(data, floc=0)
    best = optimize.minimize(
        lambda p: negative(np.exp(p[0]), np.exp(p[1])),
        [np.log(c), np.log(s)],
        method="Nelder-Mead",
        options={"xatol": 1e-12, "fatol": 1e-13, "maxiter": 10000},
    )
    shape_fit, scale_fit = np.exp(best.x)

    def profile(share, value):
        hazard = -np.log1p(-share)
        inner = optimize.minimize_scalar(
            lambda b: negative(np.exp(b), value / hazard ** np.exp(-b)),
            bounds=(np.log(shape_fit) - 3, np.log(shape_fit) + 3),
            method="bounded",
            options={"xatol": 1e-10},
        )
        return inner.fun

    lives = []
    for share in (0.1, 0.5):
        estimate = stats.weibull_min(shape_fit, scale=scale_fit).ppf(share)
        limit = best.fun + 0.5 * stats.chi2.ppf(0.95, 1)

        def end(factor):
            return optimize.brentq(lambda t: profile(share, t) - limit, estimate, estimate * factor, rtol=1e-12)

        lives.append({"share": share, "life": estimate, "low": end(0.05), "high": end(20.0)})
    return {
        "hours": hours.tolist(),
        "ended": ended.tolist(),
        "shape": shape_fit,
        "scale": scale_fit,
        "log_likelihood": -best.fun,
        "lives": lives,
    }


def anderson(seed, count, power):
    x = np.random.default_rng(seed).normal(size=count)
    x = np.sign(x) * np.abs(x) ** power
    a2 = stats.anderson(x, "norm", method="interpolate").statistic
    return {"values": x.tolist(), "statistic": a2}


ishigami = {"num_vars": 3, "names": ["a", "b", "c"], "bounds": [[-np.pi, np.pi]] * 3}
g = {"num_vars": 8, "names": list("abcdefgh"), "bounds": [[0, 1]] * 8}
reference = {
    "sobol": [
        sobol("Ishigami", Ishigami.evaluate, ishigami, 64, True),
        sobol("Ishigami, shifted", lambda x: 1e4 + Ishigami.evaluate(x), ishigami, 64, False),
        sobol("Sobol G", Sobol_G.evaluate, g, 32, False),
    ],
    "morris": [
        morris("Ishigami", Ishigami.evaluate, ishigami, 20, 4),
        morris("Sobol G", Sobol_G.evaluate, g, 12, 6),
    ],
    "clopper_pearson": clopper_pearson(),
    "weibull": [
        weibull(1, 12, 1.5, 8000.0, 1e9),
        weibull(2, 60, 3.2, 8000.0, 7500.0),
        weibull(3, 200, 0.8, 900.0, 500.0),
    ],
    "anderson_darling": [anderson(5, 20, 1.0), anderson(6, 150, 1.6)],
}
pathlib.Path(__file__).with_name("reference.json").write_text(json.dumps(reference, indent=0) + "\n")
