"""The steps of Stable Fluids in JAX, and the gradient by the velocity at the start by its reverse mode, beside `cargo bench --bench stable_fluids`.

    python3 benches/stable_fluids.py 128 40

Sweeps go by diagonals, each a step of a scan; each step of the flow is a checkpoint. f32 on one processor. The best of three of each counts."""
import pathlib, re, subprocess, sys, time
import jax, jax.numpy as jnp
from jax import lax
import numpy as np

n, steps, sweeps = int(sys.argv[1]), int(sys.argv[2]), 20
M = float(n)
y, x = np.meshgrid(np.arange(1, n + 1), np.arange(1, n + 1), indexing="ij")
D = 2 * n + 1

def skew(f):  # (n, n) -> (diagonals, x)
    out = jnp.zeros((D, n + 2), f.dtype)
    return out.at[x + y, x].set(f)

def unskew(s):
    return s[x + y, x]

d = np.arange(D)[:, None]
i = np.arange(n + 2)[None, :]
inside = (i >= 1) & (i <= n) & (d - i >= 1) & (d - i <= n)
own = ((i == 1).astype(np.float32) + (i == n) + (d - i == 1) + (d - i == n)) * inside
inside, own = jnp.asarray(inside, jnp.float32), jnp.asarray(own)

def sweep(s, b):
    def diagonal(before, row):
        old, high, b, inside, own = row
        low = before + jnp.roll(before, 1)
        up = high + jnp.roll(high, -1)
        new = inside * (b + low + up + own * old) * 0.25
        return new, new
    high = jnp.concatenate([s[1:], jnp.zeros_like(s[:1])])
    _, out = lax.scan(diagonal, jnp.zeros(n + 2, s.dtype), (s, high, b, inside, own))
    return out

def pad(f, sx=1.0, sy=1.0):
    f = jnp.concatenate([sx * f[:, :1], f, sx * f[:, -1:]], 1)
    return jnp.concatenate([sy * f[:1], f, sy * f[-1:]], 0)

def project(u, v):
    pu, pv = pad(u, -1.0), pad(v, 1.0, -1.0)
    div = -(pu[1:-1, 2:] - pu[1:-1, :-2] + pv[2:, 1:-1] - pv[:-2, 1:-1]) / (2 * M)
    b = skew(div)
    p = unskew(lax.scan(lambda s, _: (sweep(s, b), None), jnp.zeros_like(b), None, length=sweeps)[0])
    q = pad(p)
    return u - M / 2 * (q[1:-1, 2:] - q[1:-1, :-2]), v - M / 2 * (q[2:, 1:-1] - q[:-2, 1:-1])

def advect(f, u, v):  # f padded
    X = jnp.clip(x - M * u, 0.5, n + 0.5)
    Y = jnp.clip(y - M * v, 0.5, n + 0.5)
    k, l = jnp.floor(X).astype(int), jnp.floor(Y).astype(int)
    s, t = X - k, Y - l
    return (1 - t) * ((1 - s) * f[l, k] + s * f[l, k + 1]) + t * ((1 - s) * f[l + 1, k] + s * f[l + 1, k + 1])

@jax.checkpoint
def step(state, _):
    rho, u, v = state
    u, v = project(u, v)
    pu, pv = pad(u, -1.0), pad(v, 1.0, -1.0)
    u, v = project(advect(pu, u, v), advect(pv, u, v))
    return (advect(pad(rho), u, v), u, v), None

source = jnp.asarray(np.exp(-(((x / n - 0.3) ** 2 + (y / n - 0.5) ** 2) / 0.02)), jnp.float32)
target = jnp.asarray(np.exp(-(((x / n - 0.6) ** 2 + (y / n - 0.5) ** 2) / 0.02)), jnp.float32)

def J(v0):
    (rho, _, _), _ = lax.scan(step, (source, v0[0], v0[1]), None, length=steps)
    return 0.5 * jnp.sum((rho - target) ** 2)

run = jax.jit(jax.value_and_grad(J))
v0 = jnp.asarray(0.3 / steps * np.sin(np.arange(2 * n * n) * 0.013).reshape(2, n, n), jnp.float32)
value, grad = run(v0); grad.block_until_ready()
walls = []
for _ in range(3):
    w, c = time.perf_counter(), time.process_time()
    value, grad = run(v0); grad.block_until_ready()
    walls.append(time.perf_counter() - w)
    print(f"jax {jax.__version__}: {n}^2 x {steps}: J {float(value):.5g}, wall {walls[-1]:.3f} s, cpu {time.process_time() - c:.3f} s")

bench = ["cargo", "bench", "--bench", "stable_fluids", "--", str(n), str(steps)]
said = subprocess.run(bench, cwd=pathlib.Path(__file__).parent, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()
ours = float(re.search("gradient ([0-9.]+) ms", said)[1]) / 1e3
print(f"thurible: {said}")
print(f"{min(walls):.3f} s by jax, {ours:.3f} s by thurible: {min(walls) / ours:.1f} times")
