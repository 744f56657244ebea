"""A build on a Dask cluster of two worker processes, one of them killed while parts are made.

Arguments: project file, output folder. Prints the number of workers before and after.
"""

from __future__ import annotations

import os
import signal
import sys

from distributed import Client, LocalCluster
from joblib import parallel_config

from fabgeo.build import build_package
from fabgeo.build.progress import Progress


def main() -> None:
    project, out = sys.argv[1:]
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        victims = [worker["id"] for worker in client.scheduler_info()["workers"].values()]
        pids = list(client.run(os.getpid).values())
        killed: list[int] = []

        def listen(news: Progress) -> None:
            if news.stage == "unfold" and news.done >= 3 and not killed:
                killed.append(pids[0])
                os.kill(pids[0], signal.SIGKILL)

        with parallel_config("dask"):
            build_package(project, out, listener=listen)
        print(len(victims), len(killed), pids[0] in client.run(os.getpid).values())


if __name__ == "__main__":
    main()
