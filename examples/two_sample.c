/* A strapdown integrator of one's own in C: the two-sample coning algorithm, attitude only.
 *
 *   cc -O2 two_sample.c -lm -o two_sample
 *   sinsbench score --command "./two_sample {input} {output}" --on dual_precession
 */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LONGEST_LINE = 8192, COLUMNS = 7 };

static const char *const NAMES[COLUMNS] = {"angle_x",     "angle_y",     "angle_z",    "attitude0_w",
                                           "attitude0_x", "attitude0_y", "attitude0_z"};

static int fail(const char *what, const char *which) {
  fprintf(stderr, "two_sample: %s%s\n", what, which);
  return 1;
}

/* The column numbers of NAMES in a header; -1 for one that is missing. */
static void find_columns(char *header, int place[COLUMNS]) {
  for (int i = 0; i < COLUMNS; ++i) place[i] = -1;
  int column = 0;
  for (char *name = strtok(header, ",\r\n"); name; name = strtok(NULL, ",\r\n"), ++column)
    for (int i = 0; i < COLUMNS; ++i)
      if (strcmp(name, NAMES[i]) == 0) place[i] = column;
}

/* The numbers of one row. */
static void read_row(const char *line, const int place[COLUMNS], double value[COLUMNS]) {
  for (int column = 0; line; ++column) {
    for (int i = 0; i < COLUMNS; ++i)
      if (place[i] == column) value[i] = strtod(line, NULL);
    line = strchr(line, ',');
    if (line) ++line;
  }
}

/* q becomes the Hamilton product q o r, r the quaternion of a rotation vector. */
static void turn(double q[4], const double vector[3]) {
  const double angle = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
  const double factor = angle > 0 ? sin(angle / 2) / angle : 0.5;
  const double w = cos(angle / 2), x = factor * vector[0], y = factor * vector[1], z = factor * vector[2];
  const double p[4] = {q[0], q[1], q[2], q[3]};
  q[0] = p[0] * w - p[1] * x - p[2] * y - p[3] * z;
  q[1] = p[0] * x + p[1] * w + p[2] * z - p[3] * y;
  q[2] = p[0] * y - p[1] * z + p[2] * w + p[3] * x;
  q[3] = p[0] * z + p[1] * y - p[2] * x + p[3] * w;
}

int main(int argc, char **argv) {
  if (argc != 3) return fail("usage: two_sample INPUT OUTPUT", "");
  FILE *input = fopen(argv[1], "r"), *output = fopen(argv[2], "w");
  if (!input || !output) return fail("cannot open ", input ? argv[2] : argv[1]);
  char line[LONGEST_LINE];
  int place[COLUMNS];
  if (!fgets(line, sizeof line, input)) return fail("there is no header in ", argv[1]);
  find_columns(line, place);
  for (int i = 0; i < COLUMNS; ++i)
    if (place[i] < 0) return fail("there is no column ", NAMES[i]);
  double row[COLUMNS], first[3], vector[3], *q = row + 3, attitude[4];
  fputs("q_w,q_x,q_y,q_z\n", output);
  for (long sample = 0; fgets(line, sizeof line, input); ++sample) {
    read_row(line, place, row);
    if (sample == 0) {
      memcpy(attitude, q, sizeof attitude);
      fprintf(output, "%.17g,%.17g,%.17g,%.17g\n", attitude[0], attitude[1], attitude[2], attitude[3]);
    }
    if (sample % 2 == 0) {
      memcpy(first, row, sizeof first);
      continue;
    }
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      vector[i] = first[i] + row[i] + 2.0 / 3.0 * (first[j] * row[k] - first[k] * row[j]);
    }
    turn(attitude, vector);
    fprintf(output, "%.17g,%.17g,%.17g,%.17g\n", attitude[0], attitude[1], attitude[2], attitude[3]);
  }
  fclose(input);
  if (fclose(output) != 0) return fail("cannot write ", argv[2]);
  return 0;
}
