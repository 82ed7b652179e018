"""CPU time of an RPROP epoch in PyTorch: one 10-256-3 tanh network, 8000 samples, one thread."""

import time

import torch

torch.set_num_threads(1)
torch.manual_seed(1)
net = torch.nn.Sequential(torch.nn.Linear(10, 256), torch.nn.Tanh(), torch.nn.Linear(256, 3))
inputs = torch.rand(8000, 10) * 2 - 1
targets = torch.sin(inputs[:, :3] + inputs[:, 3:6])
optimizer = torch.optim.Rprop(net.parameters(), lr=0.0125)


def epoch():
    optimizer.zero_grad()
    loss = torch.nn.functional.mse_loss(net(inputs), targets)
    loss.backward()
    optimizer.step()
    return loss.item()


first = epoch()
rounds = []
for _ in range(7):
    start = time.process_time()
    for _ in range(20):
        last = epoch()
    rounds.append((time.process_time() - start) / 20 * 1e3)
assert last < 0.5 * first, "nothing was learnt"
rounds.sort()
print(
    f"PyTorch {torch.__version__}: {rounds[3]:.2f} ms of CPU an epoch "
    f"(least {rounds[0]:.2f}, most {rounds[-1]:.2f} of 7 rounds)"
)
