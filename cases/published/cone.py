"""Surface pressure of a cone in a supersonic stream, exactly (G. I. Taylor and J. W. Maccoll 1933), without any flow solver."""
import math

GAMMA = 1.4


def behind_shock(mach, beta):
    """Turning angle and Mach number behind an oblique shock, and the ratios of static and of total pressure across it."""
    normal = (mach * math.sin(beta)) ** 2
    turn = math.atan(2 / math.tan(beta) * (normal - 1) / (mach**2 * (GAMMA + math.cos(2 * beta)) + 2))
    static = 1 + 2 * GAMMA / (GAMMA + 1) * (normal - 1)
    normal_behind = (1 + (GAMMA - 1) / 2 * normal) / (GAMMA * normal - (GAMMA - 1) / 2)
    behind = math.sqrt(normal_behind) / math.sin(beta - turn)
    stagnation = lambda m: (1 + (GAMMA - 1) / 2 * m * m) ** (GAMMA / (GAMMA - 1))
    return turn, behind, static, static * stagnation(behind) / stagnation(mach)


def flow_behind(mach, beta, steps=2000):
    """Half angle of the cone whose shock has the angle beta, and the pressure coefficient on it: the equation of Taylor and Maccoll for
    velocities over their maximum, radial u and u' across, from the shock to where nothing flows across."""
    turn, behind, _, total = behind_shock(mach, beta)
    speed = 1 / math.sqrt(2 / ((GAMMA - 1) * behind**2) + 1)
    u, v, at = speed * math.cos(beta - turn), -speed * math.sin(beta - turn), beta

    def slopes(at, u, v):
        sound = (GAMMA - 1) / 2 * (1 - u * u - v * v)
        return v, (v * v * u - sound * (2 * u + v / math.tan(at))) / (sound - v * v)

    h = -beta / steps
    while v < 0:
        before = at, u, v
        a = slopes(at, u, v)
        b = slopes(at + h / 2, u + h / 2 * a[0], v + h / 2 * a[1])
        c = slopes(at + h / 2, u + h / 2 * b[0], v + h / 2 * b[1])
        d = slopes(at + h, u + h * c[0], v + h * c[1])
        u, v, at = (u + h / 6 * (a[0] + 2 * b[0] + 2 * c[0] + d[0]), v + h / 6 * (a[1] + 2 * b[1] + 2 * c[1] + d[1]), at + h)
    share = before[2] / (before[2] - v)
    angle, u = before[0] + share * h, before[1] + share * (u - before[1])
    # Static over free stream: total pressures times the isentropic ratio.
    free = (1 + (GAMMA - 1) / 2 * mach * mach) ** (GAMMA / (GAMMA - 1))
    pressure = total * free * (1 - u * u) ** (GAMMA / (GAMMA - 1))
    return angle, (pressure - 1) / (GAMMA / 2 * mach * mach)


def pressure_coefficient(mach, half_angle):
    """On a cone of this half angle in radians, with the attached, weak shock: the drag coefficient on the base."""
    low, high = math.asin(1 / mach) + 1e-6, math.radians(60)
    for _ in range(60):
        beta = (low + high) / 2
        if flow_behind(mach, beta)[0] < half_angle:
            low = beta
        else:
            high = beta
    return flow_behind(mach, beta)[1]
