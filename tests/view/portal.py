#!/usr/bin/env python3
"""A desktop whose file dialog chooses PATH, or is cancelled without one: portal.py [PATH]

Prints the address of its bus, answers one question, and ends.
"""

import sys

from gi.repository import Gio, GLib

METHOD = '''<method name="{}">
  <arg type="s" direction="in"/><arg type="s" direction="in"/><arg type="a{{sv}}" direction="in"/>
  <arg type="o" direction="out"/></method>'''
INTERFACE = ('<node><interface name="org.freedesktop.portal.FileChooser">'
             + METHOD.format("OpenFile") + METHOD.format("SaveFile") + "</interface></node>")
PLACE = "/org/freedesktop/portal/desktop"


def answer(connection, sender, _path, _interface, _method, values, invocation):
    _, _, options = values.unpack()
    request = f"{PLACE}/request/{sender[1:].replace('.', '_')}/{options['handle_token']}"
    invocation.return_value(GLib.Variant("(o)", (request,)))

    chosen = {"uris": GLib.Variant("as", [Gio.File.new_for_path(path).get_uri()])
              for path in sys.argv[1:]}
    connection.emit_signal(sender, request, "org.freedesktop.portal.Request", "Response",
                           GLib.Variant("(ua{sv})", (0 if chosen else 1, chosen)))
    connection.flush_sync()
    loop.quit()


bus = Gio.TestDBus.new(Gio.TestDBusFlags.NONE)
bus.up()
connection = Gio.bus_get_sync(Gio.BusType.SESSION)
interface = Gio.DBusNodeInfo.new_for_xml(INTERFACE).interfaces[0]
connection.register_object(PLACE, interface, answer, None, None)

loop = GLib.MainLoop()
Gio.bus_own_name_on_connection(connection, "org.freedesktop.portal.Desktop", Gio.BusNameOwnerFlags.NONE,
                               lambda *_: print(bus.get_bus_address(), flush=True), None)
loop.run()
GLib.timeout_add(200, loop.quit)  # until the answer is taken
loop.run()
bus.stop()
