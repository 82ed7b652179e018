/* CPU time of an RPROP epoch in FANN: one 10-256-3 tanh network, 8000 samples. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <fann.h>

enum { SAMPLES = 8000, EPOCHS = 10, ROUNDS = 7 };

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int main(void) {
    struct fann *net = fann_create_standard(3, 10, 256, 3);
    fann_set_activation_function_hidden(net, FANN_SIGMOID_SYMMETRIC);
    fann_set_activation_function_output(net, FANN_LINEAR);
    fann_set_training_algorithm(net, FANN_TRAIN_RPROP);
    struct fann_train_data *data = fann_create_train(SAMPLES, 10, 3);
    srand(1);
    for (int n = 0; n < SAMPLES; n++) {
        for (int i = 0; i < 10; i++)
            data->input[n][i] = 2.0 * rand() / RAND_MAX - 1.0;
        for (int k = 0; k < 3; k++)
            data->output[n][k] = sin(data->input[n][k] + data->input[n][k + 3]);
    }
    double first = fann_train_epoch(net, data), last = first, rounds[ROUNDS];
    for (int r = 0; r < ROUNDS; r++) {
        clock_t start = clock();
        for (int e = 0; e < EPOCHS; e++)
            last = fann_train_epoch(net, data);
        rounds[r] = 1e3 * (clock() - start) / CLOCKS_PER_SEC / EPOCHS;
    }
    if (!(last < 0.5 * first)) {
        fprintf(stderr, "FANN: nothing was learnt\n");
        return 1;
    }
    qsort(rounds, ROUNDS, sizeof *rounds, ascending);
    printf("FANN: %.2f ms of CPU an epoch (least %.2f, most %.2f of %d rounds)\n",
           rounds[ROUNDS / 2], rounds[0], rounds[ROUNDS - 1], ROUNDS);
    return 0;
}
