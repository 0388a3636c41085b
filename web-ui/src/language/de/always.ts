// German for what is always in sight: top bar, pages, safety strip, commands, connection, settings, keys.

export const always = {
  // pages and panels
  Map: 'Karte', Fleet: 'Flotte', Preflight: 'Vorflug', Alerts: 'Alarme', Plugins: 'Plugins', Pages: 'Seiten', Keys: 'Tasten',
  ', not acknowledged:': ', nicht bestätigt:', Formation: 'Formation', Route: 'Route', Fences: 'Zäune', Payloads: 'Nutzlast', Nodes: 'Knoten',
  Events: 'Ereignisse', Commands: 'Befehle', 'Plugins and supervision': 'Plugins und Aufsicht', 'Plans and record': 'Pläne und Verlauf',
  Plans: 'Pläne', Record: 'Verlauf', 'Fleet, plans and record': 'Flotte, Pläne und Verlauf',
  // settings
  Settings: 'Einstellungen', 'Close the settings': 'Einstellungen schließen', 'Kept in this browser.': 'Gilt in diesem Browser.', Theme: 'Farben',
  Dark: 'Dunkel', 'for a room or the night': 'für Innenräume und die Nacht', Light: 'Hell', 'for daylight': 'für Tageslicht', Sunlight: 'Sonnenlicht',
  'strongest contrast, for a screen the sun shines on': 'stärkster Kontrast, wenn die Sonne auf den Bildschirm scheint', Language: 'Sprache',
  'what the program itself says stays English': 'was das Programm selbst sagt, bleibt englisch',
  Units: 'Einheiten', Metric: 'Metrisch', Aviation: 'Luftfahrt',
  'what the program itself says and what a plugin asks for keep their units': 'was das Programm selbst sagt und was ein Plugin verlangt, behält seine Einheiten',
  // keys
  'Close the list of keys': 'Liste der Tasten schließen',
  'Keys of commands bring the button into focus and show whom it is for. Space or Enter presses it, held as long as the button wants.':
    'Tasten für Befehle wählen die Schaltfläche aus und zeigen, wem sie gilt. Leertaste oder Eingabe drückt sie, so lange gehalten, wie sie es verlangt.',
  Space: 'Leertaste', 'Held: does what the button in focus says': 'Gehalten: tut, was die ausgewählte Schaltfläche sagt',
  'Go to': 'Gehe zu', Choose: 'Auswählen', Command: 'Befehlen', 'This console': 'Diese Konsole', 'Preflight checks': 'Vorflugprüfung',
  'Alerts and events': 'Alarme und Ereignisse', 'Page of the vehicle before this, which it selects': 'Seite des vorigen Fahrzeugs, wählt es aus',
  'Page of the vehicle after this, which it selects': 'Seite des nächsten Fahrzeugs, wählt es aus',
  'Find vehicles: 3, 1-4, a name, a state; Enter goes to the button that selects them': 'Fahrzeuge finden: 3, 1-4, ein Name, ein Zustand; Eingabe geht zur Schaltfläche, die sie auswählt',
  'Lock the emergency stop, leave a tool, clear the targets': 'Nothalt sperren, Werkzeug verlassen, Ziele aufheben',
  'Emergency stop, first step': 'Nothalt, erster Schritt', 'Sound of alerts on or off': 'Alarmton ein oder aus', 'This list': 'Diese Liste',
  'HOLD ALL': 'ALLE HALTEN', 'RETURN ALL': 'ALLE ZURÜCK',
  // top bar
  'Fleet counters': 'Zähler der Flotte', vehicle: 'Fahrzeug', vehicles: 'Fahrzeuge', 'in the air': 'in der Luft', 'in air': 'in Luft',
  'on the ground': 'am Boden', 'on ground': 'am Boden', critical: 'kritisch', warning: 'Warnung', warnings: 'Warnungen', lost: 'verloren',
  'Link to the server': 'Verbindung zum Server', Server: 'Server', Latency: 'Latenz', Data: 'Daten', 'waiting for data': 'wartet auf Daten',
  'node {node}, version {version}': 'Knoten {node}, Version {version}', 'The nodes of the swarm': 'Die Knoten des Verbunds',
  'no coordinator yet': 'noch kein Koordinator', 'coordinates, term {term}': 'koordiniert, Amtszeit {term}', 'obeys {who}, term {term}': 'folgt {who}, Amtszeit {term}',
  '{who} is silent for {seconds} s': '{who} schweigt seit {seconds} s', 'node {node}': 'Knoten {node}',
  // connection
  Connection: 'Verbindung', 'This page does not fit the server': 'Diese Seite passt nicht zum Server',
  'It speaks protocol {page}, the server ({version}) speaks {server}. Reload the page.':
    'Sie spricht Protokoll {page}, der Server ({version}) spricht {server}. Seite neu laden.',
  Reload: 'Neu laden', 'Connection to the server lost': 'Verbindung zum Server verloren',
  "Commands are blocked and what is shown is old. Vehicles go on by the server's and their own rules.":
    'Befehle sind gesperrt und was zu sehen ist, ist alt. Die Fahrzeuge fliegen nach den Regeln des Servers und ihren eigenen weiter.',
  'trying now': 'versucht es jetzt', 'next try in {seconds} s': 'nächster Versuch in {seconds} s', 'Try now': 'Jetzt versuchen',
  // safety strip
  Safety: 'Sicherheit', 'Commands for every vehicle': 'Befehle für alle Fahrzeuge', 'HOLD ALL {count}': 'ALLE {count} HALTEN',
  'RETURN ALL {count}': 'ALLE {count} ZURÜCK', 'LAND ALL {count}': 'ALLE {count} LANDEN', 'Hold all': 'Alle halten', 'Return all': 'Alle zurück', 'Land all': 'Alle landen',
  'Every vehicle stops and holds its position': 'Jedes Fahrzeug bleibt stehen und hält seine Position',
  'Every vehicle flies back to its launch place and lands': 'Jedes Fahrzeug fliegt zu seinem Startplatz zurück und landet',
  'Every vehicle lands where it is': 'Jedes Fahrzeug landet, wo es ist', 'Put this message away': 'Meldung schließen',
  'First of two steps: unlocks the emergency stop for some seconds. Stops nothing by itself.':
    'Erster von zwei Schritten: entsperrt den Nothalt für einige Sekunden. Hält selbst nichts an.',
  'EMERGENCY STOP': 'NOTHALT', unlock: 'entsperren', unlocked: 'entsperrt', green: 'grün', '{count} red': '{count} rot', '{count} amber': '{count} gelb',
  'No operator heard': 'Kein Bediener gehört', 'Sign of life not heard': 'Lebenszeichen nicht gehört', 'Are you there?': 'Sind Sie da?',
  'No operator yet': 'Noch kein Bediener', 'Operator heard': 'Bediener gehört', 'I am here': 'Ich bin da',
  'Vehicles in the air react when no operator is heard for {seconds} s': 'Fahrzeuge in der Luft reagieren, wenn {seconds} s lang kein Bediener gehört wird',
  // emergency stop
  'Emergency stop unlocked': 'Nothalt entsperrt', 'Motors stop at once.': 'Die Motoren stehen sofort.', 'Nobody is in the air.': 'Niemand ist in der Luft.',
  '{count} in the air: what flies falls.': '{count} in der Luft: was fliegt, fällt.', 'Seconds left': 'Verbleibende Sekunden',
  'STOP MOTORS OF {count} SELECTED': 'MOTOREN DER {count} GEWÄHLTEN AUS', 'STOP MOTORS OF ALL {count}': 'MOTOREN ALLER {count} AUS', 'every vehicle': 'jedes Fahrzeug', 'Not only these: hold to stop all {count}': 'Nicht nur diese: halten stoppt alle {count}',
  'The motors of every vehicle stop, also of those that are not selected': 'Die Motoren aller Fahrzeuge gehen aus, auch der nicht ausgewählten',
  Cancel: 'Abbrechen', 'Time is over: emergency stop locked again': 'Zeit abgelaufen: Nothalt wieder gesperrt', 'Emergency stop not unlocked': 'Nothalt nicht entsperrt',
  'all {count}': 'alle {count}', 'Emergency stop sent to {who}': 'Nothalt gesendet an {who}', ', refused by {who}': ', abgelehnt von {who}', 'Emergency stop of {who} failed': 'Nothalt von {who} misslungen',
  // commands
  'More commands': 'Weitere Befehle', all: 'alle', Targets: 'Ziele', 'nothing selected': 'nichts ausgewählt', '{count} selected': '{count} ausgewählt', 'Select all {count}': 'Alle {count} auswählen', 'Select vehicles first': 'Erst Fahrzeuge auswählen',
  'Select vehicles first. With nothing selected only hold, land and return act, on all {count}.': 'Erst Fahrzeuge auswählen. Ist nichts ausgewählt, wirken nur Halten, Landen und Zurück, auf alle {count}.', 'Show the plan': 'Plan zeigen',
  Clear: 'Aufheben',
  'Commands for the targets': 'Befehle für die Ziele', 'Take-off height': 'Starthöhe', '{command}, each vehicle': '{command}, jedes Fahrzeug',
  'Each command says here what it will do and to whom before it is given.': 'Jeder Befehl sagt hier, was er tun wird und mit wem, bevor er gegeben wird.',
  'likely refused: {doubts}': 'wohl abgelehnt: {doubts}', Arm: 'Schärfen', Disarm: 'Entschärfen', 'Take off': 'Starten', Hold: 'Halten', Land: 'Landen', Return: 'Zurück',
  'Start the motors and stay on the ground': 'Motoren starten und am Boden bleiben', 'Stop the motors; refused in the air': 'Motoren ausschalten; in der Luft abgelehnt',
  'Arm if need be, climb to the height and hold there': 'Wenn nötig schärfen, auf die Höhe steigen und dort halten',
  'Arm if need be, climb to {height} and hold there': 'Wenn nötig schärfen, auf {height} steigen und dort halten',
  'Stop and hold the position': 'Anhalten und Position halten', 'Land where it is': 'Landen, wo es ist', 'Fly back to the launch place and land': 'Zum Startplatz zurückfliegen und landen',
  nobody: 'niemand', 'not heard': 'nicht gehört', 'flown by a pilot': 'vom Piloten geflogen', 'disarmed already': 'schon entschärft', 'armed already': 'schon geschärft',
  'not ready to arm': 'nicht bereit zum Schärfen', '{count} of {all} {phase}': '{count} von {all} {phase}', Less: 'Weniger', 'Each vehicle': 'Jedes Fahrzeug',
  'and {count} more': 'und {count} weitere', 'Target it': 'Zum Ziel machen', 'Target these {count}': 'Diese {count} zu Zielen machen', 'Show preflight': 'Vorflug zeigen',
  'outcome unknown': 'Ausgang unbekannt', 'no receipt': 'keine Quittung', 'connection lost': 'Verbindung verloren', 'the server restarted': 'der Server wurde neu gestartet', 'Commands given': 'Gegebene Befehle', '{age} ago': 'vor {age}', 'No command was given from this page yet.': 'Von dieser Seite wurde noch kein Befehl gegeben.',
  'Keep holding': 'Weiter halten', 'Hold for {seconds} seconds to confirm': 'Zum Bestätigen {seconds} Sekunden halten',
  // what is wrong with the connection
  '{missed} events did not reach this page': '{missed} Ereignisse haben diese Seite nicht erreicht', 'connection to the server lost: {reason}': 'Verbindung zum Server verloren: {reason}', 'connection to the server is back': 'Verbindung zum Server ist wieder da',
  'the server was restarted': 'der Server wurde neu gestartet', 'earlier events could not be fetched': 'frühere Ereignisse waren nicht zu bekommen', 'the server closed the connection': 'der Server hat die Verbindung geschlossen',
  'the server does not answer': 'der Server antwortet nicht', 'a text message is not JSON': 'eine Textnachricht ist kein JSON', 'the server did not understand this page: {why}': 'der Server hat diese Seite nicht verstanden: {why}',
  'no answer from the server': 'keine Antwort vom Server', 'the server cannot be reached': 'der Server ist nicht zu erreichen', 'the server answered {status}': 'der Server antwortete {status}',
} as const;
