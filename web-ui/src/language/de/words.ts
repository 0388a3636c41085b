// German for what is wrong with a vehicle and what is done about it.

export const words = {
  faulted: 'gestört', 'link lost': 'Verbindung verloren', 'data stale': 'Daten veraltet', 'battery critical': 'Akku kritisch', 'battery low': 'Akku schwach', 'control given up': 'Steuerung aufgegeben',
  'control restarting': 'Steuerung startet neu', degraded: 'eingeschränkt', 'pilot in control': 'Pilot steuert', 'no position': 'keine Position', 'no 3D fix': 'kein 3D-Fix', 'link loss {percent} %': '{percent} % Verlust',
  'out of its slot': 'nicht auf seinem Platz', 'data delayed': 'Daten verzögert', returning: 'kehrt zurück', landing: 'landet', 'out of reach': 'außer Reichweite',
  'warning only': 'nur Warnung', hold: 'halten', return: 'zurückkehren', land: 'landen', 'release to the autopilot': 'Übergabe an den Autopiloten', 'not known': 'unbekannt', limit: 'Grenze', 'for {time}': 'seit {time}',
  ', cause is over': ', Ursache vorbei', ', not taken up yet': ', noch nicht befolgt', 'Ordered: {reaction} because of {trigger}, for {time}': 'Angeordnet: {reaction} wegen {trigger}, seit {time}',
  'Kept inside of the fence': 'Innerhalb des Zauns gehalten', 'Gives way to {who}': 'Weicht {who} aus', ', {distance} away': ', {distance} entfernt', '; the distance cannot be kept': '; der Abstand ist nicht zu halten',
  'land now': 'jetzt landen', now: 'jetzt', 'motors stopped': 'Motoren aus', 'gives way': 'weicht aus', 'distance cannot be kept': 'Abstand nicht zu halten', '{trigger}: {reaction} ordered': '{trigger}: {reaction} angeordnet',
  'return soon for energy': 'bald zurück wegen Energie', 'return now for energy': 'jetzt zurück wegen Energie', 'land now for energy': 'jetzt landen wegen Energie',
} as const;
