/* The model of rcc_sim/physics as a plain C loop: what the compiled kernel is
 * measured against. Same terms, same integrator, same ledger; written by hand for
 * speed, with everything in locals.
 *
 *   model PARAMETERS CYCLE TICKS EVERY [REPEATS]
 *
 * PARAMETERS: lines of "name value"; CYCLE: lines of "time speed". Prints the best
 * time of a run, then distance, battery energy and what the ledger leaves open.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define G 9.80665

static double get(const char *file, const char *name) {
    char key[80];
    double value;
    FILE *f = fopen(file, "r");
    while (fscanf(f, "%79s %lf", key, &value) == 2)
        if (!strcmp(key, name)) { fclose(f); return value; }
    fprintf(stderr, "no parameter %s\n", name);
    exit(2);
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static double lane(double x, double every, double width, double length) {
    if (x < every) return 0;
    double k = floor(x / every), q = fmin((x - k * every) / length, 1);
    double rise = q * q * q * (10 + q * (6 * q - 15));
    return fmod(k, 2) == 1 ? width * rise : width * (1 - rise);
}

static double lane_phase(double x, double every, double length, double *sign) {
    if (x < every) return -1;
    double k = floor(x / every), q = (x - k * every) / length;
    *sign = fmod(k, 2) == 1 ? 1 : -1;
    return q >= 1 ? -1 : q;
}

static double share_beyond(double beyond, double change) {
    if (beyond >= 0.5 * change) return 1;
    if (beyond <= -0.5 * change) return 0;
    return 0.5 + beyond / change;
}

static void turn(double *v_x, double *v_y, double r, double g, double dt) {
    if (r == 0) return;
    double q = 0.5 * r * dt / g, c = (1 - q * q) / (1 + q * q), s = 2 * q / (1 + q * q);
    double w = g * *v_x, y = c * *v_y - s * w, x = c * w + s * *v_y;
    if (x < 0) { y = copysign(sqrt(y * y + x * x), y); x = 0; }
    *v_x = x / g;
    *v_y = y;
}

int main(int argc, char **argv) {
    if (argc < 5) return 2;
    const char *file = argv[1];
#define P(name) double name = get(file, #name)
    P(m); P(I_z); P(l_F); P(l_R); P(C_F); P(C_R); P(r_w); P(N_d); P(K_t); P(u_0);
    P(K_p); P(K_i); P(i_max); P(i_min); P(T); P(delta_max); P(every); P(width);
    P(length); P(B); P(J); P(R); P(dead); P(hold); P(C_rr); P(CdA); P(rho); P(T_C);
    P(T_h); P(k_e); P(eta_g); P(eta_m); P(aux); P(R_i); P(A_n); P(B_n); P(C_n);
    P(wind); P(slope); P(follow); P(w_max); P(psi_m);
    int n_ref = 0;
    static double t_ref[200000], v_tab[200000];
    FILE *f = fopen(argv[2], "r");
    while (fscanf(f, "%lf %lf", t_ref + n_ref, v_tab + n_ref) == 2) n_ref++;
    fclose(f);
    long ticks = atol(argv[3]), rows_every = atol(argv[4]);
    int repeats = argc > 5 ? atoi(argv[5]) : 5;
    double *rows = malloc(sizeof(double) * 40 * (ticks / rows_every + 2));
    double best = 1e9, E_b = 0, open_ = 0, s = 0;
    double l = l_F + l_R, n = N_d / r_w, m_x = m + J * n * n, g = sqrt(m_x / m);
    double v_slip = 0.02 * sqrt(C_F * l / m), t_char = sqrt(m * l / C_F);
    for (int rep = 0; rep < repeats; rep++) {
        double t0 = now();
        double v_x = v_tab[0], v_y = 0, r = 0, x = 0, y = 0, psi = 0, a_x = 0, I = 0, z = 0, drift = 0;
        double Kin0 = 0.5 * m_x * v_x * v_x, thru = 0;
        double e_roll = 0, e_aero = 0, e_grade = 0, e_road = 0, e_visc = 0, e_dry = 0;
        double e_iron = 0, e_gear = 0, e_cu = 0, e_eff = 0, e_aux = 0, e_batt = 0;
        double e_f = 0, e_r = 0, sum[8] = {0};
        long place = 0, row = 0;
        E_b = s = 0;
        for (long k = 0; k < ticks; k++) {
            double t = k * T, t_h = hold > 0 ? floor(t / hold + 1e-9) * hold : t;
            while (place + 2 < n_ref && t_ref[place + 1] <= t_h) place++;
            double v_ref = t_h >= t_ref[n_ref - 1] ? v_tab[n_ref - 1]
                : v_tab[place] + (v_tab[place + 1] - v_tab[place]) * ((t_h - t_ref[place])
                / (t_ref[place + 1] - t_ref[place]));
            double w_ref = fmin(v_ref * n, w_max), w = n * v_x, tau = 0;
            if (fabs(w_ref) < dead) I = 0;
            else {
                double change = n * fabs(a_x) * T;
                double e = w_ref - (dead == 0 ? w : w * share_beyond(fabs(w) - dead, change));
                double more = K_i * e * T, J_ = I + more;
                if (w_ref == 0) J_ = more = 0;
                double i = K_p * e + J_, reach = (u_0 / sqrt(3) - psi_m * w) / R;
                double high = i_max, low = -i_min;
                if (reach < 0) reach = 0;
                if (i > reach && reach < high) high = reach;
                I = J_ - more * share_beyond(e > 0 ? i - high : low - i, K_p * change);
                i = fmin(fmax(i, low), high);
                tau = K_t * i;
            }
            double delta = 0;
            if (follow != 0) {
                double look = 2 * l + 4 * t_char * v_x, sign = 0, tilt = 0, bend = 0;
                double px = x - l_R * cos(psi), py = y - l_R * sin(psi);
                double here = lane(px, every, width, length);
                double q = lane_phase(px, every, length, &sign);
                if (q >= 0) tilt = sign * width * 30 * q * q * (1 - q) * (1 - q) / length;
                double late = 0.5 * m * v_x / (C_F + C_R);
                q = lane_phase(x + late * v_x, every, length, &sign);
                if (q >= 0)
                    bend = sign * width * 60 * q * (1 + q * (2 * q - 3)) / (length * length);
                double dy = here + look * tilt - py;
                double h = atan2(dy, look) - psi - atan2(v_y - l_R * r, v_x + v_slip);
                double L = sqrt(look * look + dy * dy);
                double Ku = m / l * (l_R / (2 * C_F) - l_F / (2 * C_R));
                drift += 2 * l * (here - py) / (L * L) * v_x / (4 * L) * T;
                drift = fmin(fmax(drift, -0.2), 0.2);
                delta = (l + Ku * v_x * v_x) * bend + atan(2 * l * sin(h) / L) + drift;
                delta = fmin(fmax(delta, -delta_max), delta_max);
            }
            double sd = sin(delta), cd = cos(delta), dt = T;
            turn(&v_x, &v_y, r, g, dt / 2);
            double v = fmax(v_x + 0.5 * dt * a_x, 0), om = n * v, va = v + wind;
            double root = sqrt(1 + slope * slope);
            double roll = C_rr * m * G / root, aero = 0.5 * rho * CdA * va * fabs(va);
            double grade = m * G * slope / root, road = A_n + B_n * v + C_n * v * v;
            double visc = B * om, dry = T_C, iron = T_h + k_e * om;
            double F_F = 0, F_R = 0, vy_m = v_y, r_m = r;
            if (delta != 0 || v_y != 0 || r != 0) {
                double ac = v_y + l_F * r, uF = cd * ac - sd * v, wF = cd * v + sd * ac;
                double uR = v_y - l_R * r, WF = sqrt(wF * wF + v_slip * v_slip);
                double WR = sqrt(v * v + v_slip * v_slip);
                double KF = 2 * C_F * (cd * WF - sd * uF * wF / WF) / (WF * WF + uF * uF);
                double KR = 2 * C_R * WR / (WR * WR + uR * uR), K = KF * cd;
                F_F = -2 * C_F * atan2(uF, WF);
                F_R = -2 * C_R * atan2(uR, WR);
                double a11 = 2 * m / dt + K + KR, a12 = K * l_F - KR * l_R;
                double a22 = 2 * I_z / dt + K * l_F * l_F + KR * l_R * l_R;
                double b1 = F_F * cd + F_R, b2 = l_F * F_F * cd - l_R * F_R;
                double det = a11 * a22 - a12 * a12;
                double dv = (b1 * a22 - b2 * a12) / det, dr = (b2 * a11 - b1 * a12) / det;
                F_F -= KF * (dv + l_F * dr);
                F_R -= KR * (dv - l_R * dr);
                vy_m += dv;
                r_m += dr;
            }
            double res = roll + aero + grade + road + F_F * sd;
            double Tn = tau - visc - dry - iron;
            double kg = Tn + J * n * res / m >= 0 ? eta_g : 1 / eta_g;
            double a = (kg * n * Tn - res) / (m + kg * J * n * n), T_L = Tn - J * n * a;
            double v1 = v_x + a * dt, mov = dt;
            if (v1 <= 0) { mov = a < 0 ? fmin(-v_x / a, dt) : 0; v1 = 0; }
            double vm = 0.5 * (v_x + v1), ds = vm * mov;
            e_f -= F_F * ((vy_m + l_F * r_m) * cd * dt - sd * ds);
            e_r -= F_R * (vy_m - l_R * r_m) * dt;
            e_roll += roll * ds; e_aero += aero * ds; e_grade += grade * ds;
            e_road += road * ds; e_visc += visc * n * ds; e_dry += dry * n * ds;
            e_iron += iron * n * ds; e_gear += (1 - kg) * T_L * n * ds;
            double iq = tau / K_t, Ps = tau * n * vm * mov / dt, Pc = 1.5 * R * iq * iq;
            double Pl = Ps >= 0 ? Ps / eta_m - Ps : Ps * eta_m - Ps;
            double Pb = Ps + Pc + Pl + aux;
            double ib = 2 * Pb / (u_0 + sqrt(u_0 * u_0 - 4 * R_i * Pb)), sag = R_i * ib * ib;
            e_cu += Pc * dt; e_eff += Pl * dt; e_aux += aux * dt; e_batt += sag * dt;
            E_b += (Pb + sag) * dt;
            thru += fabs(Pb + sag) * dt;
            double am = (v1 - v_x) / dt;
            sum[0] += am + (m / m_x - 1) * v_y * r_m + grade / m;
            sum[1] += (F_F * cd + F_R) / m; sum[2] += iq; sum[3] += tau; sum[4] += Pb;
            sum[5] += ib; sum[6] += u_0 - R_i * ib;
            double ps = psi + 0.5 * dt * r_m;
            if (ps == 0 && vy_m == 0) x += ds;
            else {
                double c = cos(ps), sn = sin(ps);
                x += vm * c * mov - vy_m * sn * dt;
                y += vm * sn * mov + vy_m * c * dt;
            }
            psi += dt * r_m;
            a_x = am; v_x = v1; v_y = 2 * vy_m - v_y; r = 2 * r_m - r;
            s += ds;
            z += ds * slope / root;
            turn(&v_x, &v_y, r, g, dt / 2);
            if ((k + 1) % rows_every == 0) {
                double *o = rows + 40 * row++;
                double line[] = {t, v_ref, delta, v_x, v_y, r, x, y, psi, z, s, E_b, thru,
                    e_roll, e_aero, e_grade, e_road, e_visc, e_dry, e_iron, e_gear, e_cu,
                    e_eff, e_aux, e_batt, e_f, e_r};
                memcpy(o, line, sizeof line);
                for (int j = 0; j < 8; j++) { o[30 + j] = sum[j] / rows_every; sum[j] = 0; }
            }
        }
        double kin = 0.5 * (m_x * v_x * v_x + m * v_y * v_y + I_z * r * r) - Kin0;
        open_ = (E_b - (kin + e_roll + e_aero + e_grade + e_road + e_visc + e_dry + e_iron
            + e_gear + e_cu + e_eff + e_aux + e_batt + e_f + e_r)) / thru;
        double took = now() - t0;
        if (took < best) best = took;
    }
    printf("%.6f %.10g %.10g %.2e\n", best, s, E_b, open_);
    free(rows);
    return 0;
}
