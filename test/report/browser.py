"""A headless Chromium, spoken to over a pipe in its own protocol: no driver and no network."""

import base64
import json
import os
import select
import shutil
import subprocess
import time
from contextlib import contextmanager

PROGRAM = shutil.which('chromium') or shutil.which('chromium-browser') or shutil.which('google-chrome')
_PATIENCE = 60.0  # s


class Page:
    """One page: ``show`` loads a file, ``ask`` evaluates an expression, ``complaints`` is what its console said."""

    def __init__(self, to, come):
        self._to, self._come, self._rest, self._count = to, come, b'', 0
        self.complaints, self._loaded, self._session = [], False, None
        target = self.call('Target.createTarget', url='about:blank')['targetId']
        self._session = self.call('Target.attachToTarget', targetId=target, flatten=True)['sessionId']
        for domain in ('Page', 'Runtime', 'Log', 'Network'):
            self.call(f'{domain}.enable')

    def call(self, method, **parameters):
        self._count += 1
        number = self._count
        message = {'id': number, 'method': method, 'params': parameters}
        if self._session:
            message['sessionId'] = self._session
        os.write(self._to, json.dumps(message).encode() + b'\0')
        return self._until(lambda m: m.get('id') == number)['result']

    def show(self, path, width=1200, dark=False, height=900):
        scheme = {'name': 'prefers-color-scheme', 'value': 'dark' if dark else 'light'}
        self.call('Emulation.setEmulatedMedia', features=[scheme])
        self.call('Emulation.setDeviceMetricsOverride', width=width, height=height, deviceScaleFactor=1, mobile=False)
        self._loaded = False
        self.call('Page.navigate', url=path.as_uri())
        if not self._loaded:
            self._until(lambda m: m.get('method') == 'Page.loadEventFired')

    def ask(self, expression):
        answer = self.call('Runtime.evaluate', expression=expression, returnByValue=True, awaitPromise=True)
        assert 'exceptionDetails' not in answer, answer['exceptionDetails']
        return answer['result'].get('value')

    def picture(self, path, whole=False):
        data = self.call('Page.captureScreenshot', captureBeyondViewport=whole)['data']
        path.write_bytes(base64.b64decode(data))

    def _until(self, wanted):
        end = time.monotonic() + _PATIENCE
        while True:
            while b'\0' not in self._rest:
                self._rest += self._more(end)
            line, _, self._rest = self._rest.partition(b'\0')
            message = json.loads(line)
            self._hear(message)
            if wanted(message):
                assert 'error' not in message, message
                return message

    def _more(self, end):
        """What the browser says next. TimeoutError: nothing until ``end``; EOFError: it is gone."""
        if not select.select([self._come], [], [], max(end - time.monotonic(), 0.0))[0]:
            raise TimeoutError('the browser does not answer')
        said = os.read(self._come, 1 << 20)
        if not said:
            raise EOFError('the browser has ended')
        return said

    def _hear(self, message):
        method, said = message.get('method'), message.get('params', {})
        self._loaded |= method == 'Page.loadEventFired'
        if method == 'Runtime.exceptionThrown':
            self.complaints.append(said['exceptionDetails']['exception'].get('description', 'exception'))
        if method == 'Runtime.consoleAPICalled':
            self.complaints.append(f'{said["type"]}: {said["args"]}')
        if method == 'Log.entryAdded':
            self.complaints.append(said['entry']['text'])
        if method == 'Network.requestWillBeSent' and not said['request']['url'].startswith(('file:', 'data:')):
            self.complaints.append(f'fetches {said["request"]["url"]}')


@contextmanager
def browser(profile):
    """A page of a new browser that keeps its files in the folder ``profile``."""
    to_browser, ours = os.pipe()
    come, from_browser = os.pipe()
    options = ['--headless=new', '--no-sandbox', '--disable-gpu', '--no-first-run', '--remote-debugging-pipe']
    # It loads files alone: nothing of the browser's own is to be fetched meanwhile.
    options += ['--disable-quic', '--disable-background-networking', '--disable-component-update', '--disable-sync']
    options += ['--disable-dev-shm-usage']  # a container's is small
    options += [f'--user-data-dir={profile}']
    process = subprocess.Popen(
        ['bash', '-c', f'exec "$0" "$@" 3<&{to_browser} 4>&{from_browser}', PROGRAM, *options],
        pass_fds=(to_browser, from_browser),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(to_browser)
    os.close(from_browser)
    try:
        yield Page(ours, come)
    finally:
        process.terminate()
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        os.close(ours)
        os.close(come)
