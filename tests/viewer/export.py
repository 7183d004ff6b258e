"""The folder that the page is shown from: `lightcook view DIR --export FOLDER`, with the page as viewer/ has it now."""
import pathlib
import shutil
import subprocess


def export(lightcook, cooked, folder, bundle):
    """bundle: folder that viewer/build.mjs wrote."""
    done = subprocess.run([str(lightcook), 'view', str(cooked), '--export', str(folder)], capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(f'lightcook view {cooked}: exit code {done.returncode}\n{done.stdout}{done.stderr}')
    shutil.copytree(bundle, pathlib.Path(folder), dirs_exist_ok=True)
